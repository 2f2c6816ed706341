"""Arrays as users have them: taken by their values, refused where something would be lost."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

from msvalidate.problem import Mesh, ProblemError
from msvalidate.problem.checks import finite, finite_number, indices, shaped
from msvalidate.springs.network import energy, internal_force, spring_network
from msvalidate.springs.network.laws.volumes import Volumes
from reference_fem.mesh.discretisation import make_discretisation
from tests.table import table

CORNERS = 0.37 * np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) + 4.3
RING = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
HELD = np.array([[True, True], [False, True], [False, False], [False, False]])


class WithUnit(np.ndarray):
    """As quantities of astropy are: NumPy takes their values and drops the unit."""

    unit = "mm"


def ring(**change):
    return spring_network(**({"points": CORNERS, "springs": RING, "stiffness": 0.3} | change))


def indices_to(what, cells):
    """What becomes of numbers of points in a network, a mesh and lists of cells."""
    if what == "network":
        return ring(springs=cells).springs
    if what == "mesh":
        return Mesh(CORNERS, cells, "quad").cells
    if what == "volumes":
        return Volumes(CORNERS, cells, [0.2]).cells
    return make_discretisation(CORNERS, cells, "Q1").cells


@table("what", ["network", "mesh", "volumes", "finite elements"])
@table("bad", [float("nan"), float("inf"), 0.5, True])
def test_indices_that_are_none_are_refused_without_a_warning(bad, what):
    plain = np.array(RING if what == "network" else [[0, 1, 2, 3]], dtype=float)
    plain[0, 0] = bad
    given = plain if bad is not True else plain.astype(bool)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ProblemError):
            indices_to(what, given)


@table("held", [2 * HELD, HELD.astype(str), HELD + 0j, HELD[:2], np.nan * HELD])
def test_what_is_no_boolean_is_refused(held):
    with pytest.raises(ProblemError, match=r"fixed: .*give booleans \(4, 2\)"):
        ring(fixed=held)


MASKED = np.ma.array([0.3, 0.4, 0.5, 0.6], mask=[0, 0, 1, 0])


@table(
    "change",
    [
        {"stiffness": MASKED},
        {"points": np.ma.masked_less(CORNERS, 4.5)},
        {"springs": np.ma.masked_greater(RING, 2)},
        {"fixed": np.ma.array(HELD, mask=HELD)},
    ],
)
def test_masked_arrays_are_refused(change):
    # Their fill values were stiffnesses of 1e20 N/m, or what stood behind the mask.
    with pytest.raises(ProblemError, match=f"{next(iter(change))}: a masked array"):
        ring(**change)


def test_positions_of_fewer_digits_do_not_pass_by():
    network = ring(rest_length=0.3)
    position = CORNERS.astype(np.float32)  # in its own type, lengths would have 7 digits
    exact = 0.5 * 0.3 * ((0.37 - 0.3) ** 2 * 4)
    # Float32 keeps 4.3 m to 2.4e-7 m; a stretch of 0.07 m is then off by 7e-6 of itself, squared.
    assert energy(network, position) == pytest.approx(exact, rel=2e-5)
    assert internal_force(network, position).dtype == np.float64
    direct = energy(network, position.astype(float))
    assert energy(network, position) == direct


@table("bad", [CORNERS + 0j, CORNERS.astype(str), CORNERS.view(WithUnit)])
def test_what_would_lose_something_is_refused(bad):
    with pytest.raises(ProblemError, match="points: "):
        ring(points=bad)


class Elsewhere:
    """As tensors are that have gradients or live on a GPU: they refuse to become arrays."""

    def __array__(self, dtype=None, copy=None):
        raise TypeError("copy to host")


def test_what_refuses_to_become_an_array_is_told():
    with pytest.raises(ProblemError, match="force: no array, "):
        ring(force=Elsewhere())


@pytest.mark.parametrize(("asked", "message"), [
    (lambda: shaped("x", np.zeros((0, 2)), "n>0", (2, 3)), "x: shape (0, 2); give (n, 2) or"),
    (lambda: shaped("x", np.zeros((2, 2)), "n>2", 2), "x: shape (2, 2); give (n, 2), n above 2"),
    (lambda: shaped("x", np.zeros((4, 4)), "n", (2, 3)), "give (n, 2) or (n, 3)"),
    (lambda: finite("x", 1.0, 1), "x: shape (); give (1,)"),
    (lambda: finite("x", [1.0], 2, need="two ends"), "x: shape (1,); two ends"),
    (lambda: indices("x", [0, 3], 3, "n"), "x: points 0 to 3; there are 3, from 0"),
    (lambda: indices("x", [-1], 3, "n"), "x: points -1 to -1; there are 3, from 0"),
    (lambda: finite_number("x", 1, below=1), "x: 1; give a number below 1"),
    (lambda: finite_number("x", 0.0, above=0, most=1, unit="m"),
        "x: 0.0 m; give a number above 0 and"),
    (lambda: finite_number("x", 1.5, above=0, most=1),
        "x: 1.5; give a number above 0 and at most 1"),
    (lambda: finite_number("x", -1e-9, least=0), "x: -1e-09; give a number of 0 or more"),
])  # fmt: skip
def test_another_shape_or_range_is_refused(asked, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        asked()
