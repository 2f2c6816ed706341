"""What the set asks: bodies, how they are held and loaded, and the grids that they are meshed by.

Each statement is the text of a case file with a place for Poisson's ratio, so that what is frozen,
what the reference solves and what anybody reads are one thing. All bodies are of E = 10 MPa and
1000 kg/m³, of sides that are short binary fractions of a metre wherever the body allows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
RATIOS = (0.0, 0.25, 0.3, 0.4, 0.45)
RUBBER = (0.49, 0.4999)
OWN_RATIO = 0.3
"""The ratio that a frozen case file names, where the set has it; else the first."""
E, DENSITY, THICKNESS = 1e7, 1000.0, 0.125
STRESS = "plane_stress"
STRAIN = "plane_strain"
SPACE = "space"
UNIFORM = ("pull", "pressure", "shear")
"""States of uniform stress."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Lines of a grid in parameters, and where its cells lie in the body.

    Parameters
    ----------
    marks
        Along each axis, parameters that every mesh has a line at.
    cells
        Along each axis, cells of the coarsest mesh between neighbouring marks.
    sharp
        Along each axis, numbers of the marks where stress is singular: the reference's lines
        crowd there.
    place
        Parameters (n, d) -> places (n, d) in m; None where they are the same.
    kept
        Middles (c, d) in parameters -> whether a cell is of the body; None if all are.
    """

    marks: tuple[tuple[float, ...], ...]
    cells: tuple[tuple[int, ...], ...]
    sharp: tuple[tuple[int, ...], ...]
    place: Callable[[Array], Array] | None = None
    kept: Callable[[Array], Array] | None = None


@dataclass(frozen=True, eq=False)
class Statement:
    """One body, held and loaded one way, in one state.

    Parameters
    ----------
    body, state
        Names; the case is called by both.
    text
        Of a case file, without the tables that every case has alike.
    grid
        Its meshes.
    meshes
        How many resolutions are frozen.
    ratios
        Poisson's ratios of the set.
    sides
        Name -> which places (n, d) in m lie on it, of bodies that are given as meshes.
    """

    body: str
    state: str
    text: str
    grid: Grid
    meshes: int = 2
    ratios: tuple[float, ...] = RATIOS
    sides: dict[str, Callable[[Array], Array]] | None = None

    @property
    def name(self) -> str:
        """The case's name, and its folder's."""
        return f"{self.body}_{self.state}"

    @property
    def dim(self) -> int:
        """Number of axes."""
        return len(self.grid.marks)

    @property
    def is_uniform(self) -> bool:
        """Whether stress is uniform: its closed form is all the confirmation that it needs."""
        return self.body in {f"{b}_{s}" for b in ("cell", "block") for s in UNIFORM}

    @property
    def own_ratio(self) -> float:
        """Poisson's ratio in the frozen case file."""
        return OWN_RATIO if OWN_RATIO in self.ratios else self.ratios[0]

    def case_file(self, nu: float, mesh: str | None = None) -> str:
        """Text of the case file, for a ratio; of another mesh than its own, if one is named."""
        lines = ["schema = 1", f'name = "{self.name}"']
        text = self.text.replace("NU", f"{nu:g}")
        if mesh is not None:
            text = text.replace('"body.msh"', f'"{mesh}"')
        body, rest = text.split("\n\n", 1)
        material = ["[material]", f"E = {E:g}", f"nu = {nu:g}", f"density = {DENSITY:g}"]
        if self.dim == 2:
            material += [f'state = "{self.state}"', f"thickness = {THICKNESS:g}"]
        return "\n".join([*lines, body.strip(), *material, rest.strip(), ""])
