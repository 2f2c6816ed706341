"""The first question: cells and dimension of a program, which its adapter declares."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Isotropic, Mesh, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.exchange.protocol import (
    DIMENSION,
    CannotRepresent,
    Request,
    Simulator,
    SimulatorError,
)

TETRA = ("tetra", 3)
"""Cells and number of axes of adapters that do not know the question."""


def declared_cells(simulator: Simulator) -> tuple[str, int]:
    """Return the first of the declared cells, and the number of axes.

    An adapter that fails, or declares nothing, has tetrahedra.

    Raises
    ------
    ProblemError
        If cells are unknown, or points have no dimension.
    """
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    request = Request(
        "declare", Mesh(corners, np.arange(4)[None], "tetra"), Isotropic(1e7, 0.3, "solid"),
        mass=np.full(4, 1000 / 24), gravity=np.zeros(3), force=np.zeros((4, 3)),
        held=np.zeros((4, 3), dtype=bool), value=np.zeros((4, 3)), name="declaration",
    )  # fmt: skip
    try:
        about = simulator(request).about
    except (CannotRepresent, SimulatorError):
        return TETRA
    cells = about.get("cells") or TETRA[:1]
    known = {**DIMENSION, "points": about.get("dimension")}
    if known.get(cells[0]) not in {2, 3}:
        raise ProblemError(
            f"declared cells {format_value(cells[0])}: give some of {', '.join(known)}; points "
            "need a dimension, 2 or 3"
        )
    return cells[0], int(known[cells[0]] or 3)
