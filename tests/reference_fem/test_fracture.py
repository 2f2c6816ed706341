"""`reference_fem.fracture`: energy release rates by two routes, against an independent program."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import (
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
    Weight,
)
from msvalidate.problem.records import replace
from reference_fem.fracture import crack_mesh, release_rate


def plate(scale=1.0, E=8 / 3, thickness=1.0):
    """Half of a plate 1.5 times as high as wide either side of an edge crack, by its length."""
    high = 1.5 * scale

    def at(a):
        return Problem(
            Box((scale, high)), Isotropic(E, 1 / 3, thickness=thickness),
            (Support(Region(((a, scale), 0.0)), (None, 0.0)),
             Support(Region((scale, 0.0)), (0.0, None))),
            (Traction(Region((None, high)), (0.0, 1.0)),),
        )  # fmt: skip

    return at


def test_an_edge_crack_by_both_routes():
    """1.65987: spectral elements, to 1e-4, whatever the units and the size."""
    scale, E, thickness = 0.37, 2e5, 0.2
    a = 0.3 * scale
    found = release_rate(plate(scale, E, thickness), lambda a: (a, 0.0), a, 0.02 * scale)
    Y = np.sqrt(2 * E * np.array([found.value, found.integral]) / thickness / (np.pi * a))
    assert pytest.approx(1.659872697580806, rel=2e-4) == Y


def beam(a):
    """Half of a notched beam that cracks upwards, under spread forces."""
    return Problem(
        Box((2.25, 1.0)), Isotropic(8 / 3, 1 / 3),
        (Support(Region((0.0, (a, 1.0))), (0.0, None)),
         Support(Region((0.0, 1.0)), (None, 0.0))),
        (Traction(Region(((0.0, 0.05), 1.0)), (0.0, -10.0)),
         Traction(Region(((1.95, 2.05), 0.0)), (0.0, 5.0))),
    )  # fmt: skip


@pytest.mark.parametrize("step", [0.02, *np.random.default_rng(0).uniform(0.002, 0.15, 3)])
@pytest.mark.parametrize(("length", "known"), [(0.3, 1.5126236600893834), (0.5, 2.641000654501948)])
def test_the_uncertainty_covers_at_any_step(length, known, step):
    """K W^1.5/(P S) by spectral elements to 1e-4, so G to twice that."""
    found = release_rate(beam, lambda a: (0.0, a), length, step)
    G = (4 * known) ** 2 / (2 * 8 / 3)
    assert found.integral == pytest.approx(G, rel=2e-3)
    assert abs(found.value - G) <= found.uncertainty + 2e-4 * G
    assert step > 0.02 or found.uncertainty < 3e-3 * G


def test_other_loads_are_refused():
    moved = (Support(Region((None, 1.5)), (None, 0.01)),)
    weight = (Weight((0.0, -9.81)),)
    for change, step in (({"supports": moved}, 0.02), ({"loads": weight}, 0.02), ({}, 0.0)):

        def at(a, change=change):
            given = plate()(a)
            supports = (*given.supports, *change.get("supports", ()))
            return replace(given, supports=supports, loads=change.get("loads", given.loads))

        with pytest.raises(ProblemError, match=r"crack: supports that move|step: 0 m"):
            release_rate(at, lambda a: (a, 0.0), 0.3, step)


def test_cells_take_plane_boxes():
    solid = Problem(
        Box((1.0, 1.0, 1.0)), Isotropic(1.0, 0.3, state="solid"),
        (Support(Region((None, None, 0.0)), (0.0, 0.0, 0.0)),),
    )  # fmt: skip
    with pytest.raises(ProblemError, match="crack: elements take a plane box"):
        crack_mesh(solid, (0.5, 0.0, 0.0))
