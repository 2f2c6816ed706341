"""The statement of a problem: bad input refused by name, boxes, regions, materials."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import (
    Anisotropic,
    BodyForce,
    Box,
    Isotropic,
    PointForce,
    Problem,
    Region,
    Support,
    Traction,
    corners_of,
)
from msvalidate.problem.checks import finite
from tests.table import refused, table

NAN = float("nan")
PLATE = Box((2.0, 1.0))
BLOCK = Box((2.0, 1.0, 3.0))
SHEET = Isotropic(E=1e6, nu=0.3)
CLAMP = Support(PLATE.side("left"), (0.0, 0.0))


def plate(*, supports=(CLAMP,), loads=()):
    return Problem(PLATE, SHEET, supports, loads)


# Bad input ------------------------------------------------------------------------------------


@table(("make", "message"), [
    # values
    (lambda: finite("mass", [1.0, NAN]), "mass: nan at index 1; every value must be finite"),
    (lambda: finite("force", [[0, 1], [np.inf, 0]]), "force: inf at index (1, 0)"),
    # domain
    (lambda: Box((1.0,)), "give 2 or 3 lengths"),
    (lambda: Box((1.0, 0.0)), "box size along y: 0.0 m; it must be above zero"),
    (lambda: Box((1.0, 1.0, NAN)), "box size along z: nan"),
    (lambda: PLATE.side("front"), "side 'front': a 2D box has left, right, bottom, top"),
    (lambda: BLOCK.side("north"), "side 'north': a 3D box has left, right, bottom, top, back"),
    (lambda: Region((0.0,)), "region: (0.0,); give a tuple of 2 or 3 entries"),
    (lambda: Region((NAN, None)), "x: nan; every value must be finite"),
    (lambda: Region((None, (1.0, 0.0))), "y must be a number, (low, high) or None"),
    (lambda: Region((None, (1.0, 1.0))), "y must be a number, (low, high) or None"),
    (lambda: Region(((0.0, 1.0, 2.0), None)), "x must be a number, (low, high) or None"),
    (lambda: Region(([0.0, 1.0], None)), "x must be a number, (low, high) or None"),
    *((lambda entry=entry: Region((entry, None)), "x") for entry in ("left", (0.0,))),
    (lambda: corners_of(Region((0.0, 0.0, 0.0)), PLATE), "has 3 axes, the body 2"),
    (lambda: corners_of(Region((2.1, None)), PLATE), "reaches outside the body, 0 <= x <= 2"),
    (lambda: corners_of(Region((None, (-0.5, 1.0))), PLATE),
        "reaches outside the body, 0 <= y <= 1"),
    # material
    (lambda: Isotropic(E=-1.0, nu=0.3), "Young's modulus E: -1.0 Pa; it must be above zero"),
    (lambda: Isotropic(E=NAN, nu=0.3), "Young's modulus E: nan"),
    (lambda: Isotropic(E=1.0, nu=0.51), "nu: 0.51; a stable material has -1 < nu <= 1/2"),
    (lambda: Isotropic(E=1.0, nu=-1.0), "nu: -1.0; a stable material has -1 < nu <= 1/2"),
    (lambda: Isotropic(E=1.0, nu=NAN), "Poisson's ratio nu: nan"),
    (lambda: Isotropic(E=1.0, nu=0.3, density=0.0), "density: 0.0 kg/m³"),
    (lambda: Isotropic(E=1.0, nu=0.3, state="solid", thickness=2.0), "a solid has none"),
    (lambda: Anisotropic(np.eye(4)), "shape (4, 4); give (3, 3) or (6, 6)"),
    (lambda: Anisotropic(np.triu(np.ones((3, 3)))), "not symmetric"),
    (lambda: Anisotropic(np.diag([1.0, -1.0, 1.0])), "lowest eigenvalue -1 Pa"),
    (lambda: Anisotropic(np.diag([1.0, NAN, 1.0])), "stiffness tensor C: nan at index (1, 1)"),
    (lambda: Anisotropic(np.eye(6), thickness=2.0), "a solid has none"),
    # supports
    (lambda: Support(Region((0.0, None)), (0.0,)), "1 components for 2 axes"),
    (lambda: Support(Region((0.0, None)), (0.0, 0.0, 0.0)), "3 components for 2 axes"),
    (lambda: Support(Region((0.0, None)), (None, None)), "holds no component; leave it out"),
    (lambda: Support(Region((0.0, None)), (0.0, NAN)), "support on (x = 0): nan"),
    (lambda: Support(Region((0.0, None)), ([1.0, 2.0], 0.0)), "support"),
    (lambda: plate(supports="left"), "supports 'left'; give a list of Support"),
    (lambda: plate(supports=Support("front")), "side 'front': a 2D box has left, right, bottom"),
    (lambda: plate(supports=(CLAMP, Support(Region((3.0, None)), (0.0, None)))),
        "region (x = 3) reaches outside the body, 0 <= x <= 2"),
    (lambda: plate(supports=(CLAMP, Support(Region((0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)))),
        "has 3 axes, the body 2"),
    # loads
    (lambda: PointForce((0.0, 0.0), (1.0, 0.0, 0.0)), "give 2 or 3 numbers each"),
    (lambda: PointForce((0.0,), (1.0,)), "give 2 or 3 numbers each"),
    (lambda: PointForce((0.0, NAN), (1.0, 0.0)), "place of a point force: nan at index 1"),
    (lambda: PointForce((0.0, 0.0), (NAN, 0.0)), "point force: nan at index 0"),
    (lambda: plate(loads=(PointForce((2.5, 0.0), (1.0, 0.0)),)), "reaches outside the body"),
    (lambda: plate(loads=(PointForce((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),)),
        "has 3 axes, the body 2"),
    (lambda: Traction(Region((None, (0.0, 1.0))), (1.0, 0.0)),
        "traction on (0 <= y <= 1): a traction acts on a side of the body, where exactly one"),
    (lambda: Traction(Region((2.0, 1.0)), (1.0, 0.0)), "traction on (x = 2, y = 1): a"),
    (lambda: Traction(BLOCK.side("left"), (1.0, 0.0)), "give 3 components"),
    (lambda: Traction(PLATE.side("left"), (1.0, NAN)), "traction on (x = 0): nan at index 1"),
    (lambda: plate(loads=(Traction(Region((1.0, None)), (1.0, 0.0)),)),
        "traction on (x = 1): from (1, 0) to (1, 1) m it is not on one side of the body all"),
    (lambda: plate(loads=(BodyForce((0.0, NAN)),)), "body force: nan at index 1"),
    (lambda: BodyForce.gravity(0.0, (0.0, -9.81)), "gravity: density: 0.0 kg/m³; it must be"),
    (lambda: BodyForce.gravity(NAN, (0.0, -9.81)), "gravity: density: nan"),
    (lambda: BodyForce.gravity(1e3, -9.81), "gravity: shape (); give 2 or 3 components in m/s²"),
    (lambda: BodyForce.gravity(1e3, (0.0, NAN)), "gravity: nan at index 1"),
    # the whole
    (lambda: Problem(BLOCK, SHEET, (Support(BLOCK.side("left"), (0.0, 0.0, 0.0)),)),
        "problem: a 2D material in a 3D domain"),
])  # fmt: skip
def test_bad_input_is_refused_by_name(make, message):
    with refused(message):
        make()


# Material -------------------------------------------------------------------------------------


@pytest.mark.parametrize("nu", [-0.99, 0.0, 0.5])
def test_every_stable_ratio_is_a_material(nu):
    assert Isotropic(E=1.0, nu=nu).nu == nu


def test_a_tensor_is_copied_and_frozen():
    C = np.diag([2.0, 2.0, 1.0])
    material = Anisotropic(C)
    C[0, 0] = 7.0
    assert material.C[0, 0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        material.C[0, 0] = 7.0


def test_dimension_follows_the_state_or_the_tensor():
    assert Isotropic(E=1.0, nu=0.3).dim == Isotropic(E=1.0, nu=0.3, state="plane_strain").dim == 2
    assert Isotropic(E=1.0, nu=0.3, state="solid").dim == 3
    assert (Anisotropic(np.eye(3)).dim, Anisotropic(np.eye(6)).dim) == (2, 3)
