"""Strain and stress at points: exact fields, orders, bad questions."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Anisotropic, Box, Isotropic, ProblemError
from reference_fem.body import Solution
from reference_fem.mesh import ELEMENTS, make_discretisation
from tests.reference_fem.by_hand import compliance

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

ROUNDING = 1e-11
"""Relative: differences of displacements over a tenth of a body lose one digit of twelve."""
every_element = pytest.mark.parametrize("element", ELEMENTS)


def distorted(element, n=3, seed=0, bent=False):
    """A box of moved nodes: of corners, or of all nodes, which bends the edges."""
    d = ELEMENTS[element].dim
    kind = ELEMENTS[element]
    flat = reference_fem.box_discretisation(Box((1.2, 0.8, 1.0)[:d]), n, element)
    points = flat.points.copy()
    inner = ~np.isin(np.arange(len(points)), flat.surface)
    step = np.random.default_rng(seed).uniform(-0.04, 0.04, points.shape)
    points[inner] += step[inner] / (2 if bent else 1)
    if not bent:
        means = np.einsum("ik,ckd->cid", kind.means, points[flat.cells[:, : kind.corners]])
        points[flat.cells] = means
    return make_discretisation(points, flat.cells, element)


def places(d, number=60, seed=1):
    return np.random.default_rng(seed).random((number, d)) * (1.2, 0.8, 1.0)[:d]


def materials(d):
    mixed = np.random.default_rng(3).uniform(-0.2, 0.2, (3 * d - 3, 3 * d - 3))
    C = np.diag([3.0, 2.0, 2.5, 1.1, 0.9, 1.3][: 3 * d - 3]) + mixed + mixed.T
    if d == 3:
        return [Isotropic(2.0, 0.3, "solid"), Anisotropic(C)]
    return [Isotropic(2.0, 0.3), Isotropic(2.0, 0.3, "plane_strain"), Anisotropic(C)]


def hooke(law, strain):
    """Stress (p, 3 or 6) by the compliance, as engineers write it."""
    if isinstance(law, Anisotropic):
        return strain @ law.C
    S, plane = compliance(law.E, law.nu), np.ix_([0, 1, 5], [0, 1, 5])
    if law.state == "plane_stress":
        return np.linalg.solve(S[plane], strain.T).T
    full = np.linalg.inv(S)
    return strain @ (full[plane] if law.state == "plane_strain" else full)


VOIGT = {2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}


def voigt(gradient):
    """Engineering strains (p, 3 or 6) of gradients (p, d, d)."""
    d = gradient.shape[1]
    e = (gradient + gradient.transpose(0, 2, 1)) / 2
    return np.stack([e[:, a, b] * (1 if a == b else 2) for a, b in VOIGT[d]], axis=1)


@every_element
@pytest.mark.parametrize("bent", [False, True])
def test_uniform_strain_is_exact(element, bent):
    body = distorted(element, bent=bent)
    assert body.curved == (bent and ELEMENTS[element].degree == 2)
    d = body.dim
    gradient = 1e-3 * np.random.default_rng(2).normal(size=(d, d))
    x = np.vstack([places(d), body.points])
    wanted = np.tile(voigt(gradient[None]), (len(x), 1))
    for law in materials(d):
        found = Solution(body, body.points @ gradient.T, law)
        assert np.abs(found.strain(x) - wanted).max() <= ROUNDING * np.abs(wanted).max()
        stress = hooke(law, wanted)
        assert np.abs(found.stress(x) - stress).max() <= ROUNDING * np.abs(stress).max()


def vaulted(points):
    """A box of 1.2 x 0.8 (x 1) m mapped smoothly onto a body with bent sides."""
    bent = points.copy()
    bent[:, 0] += 0.1 * np.sin(4 * points[:, 1])
    bent[:, 1:] += 0.1 * np.sin(3 * points[:, :1])
    return bent


@every_element
@pytest.mark.parametrize("bent", [False, True])
def test_order_of_the_stress_is_that_of_the_gradient(element, bent):
    # Of an interpolated wave, so that nothing but the evaluation is at work.
    d = ELEMENTS[element].dim
    k = np.array([2.1, -1.3, 0.8])[:d]
    law = materials(d)[0]
    direction = np.array([1.0, 0.5, -0.7])[:d]
    margin = 0.1 if bent else 0.0  # chords and parabolas leave the smooth outline
    flat = margin + (1 - 2 * margin) * places(d, 3000)
    x = vaulted(flat) if bent else flat
    wanted = hooke(law, voigt(np.cos(x @ k)[:, None, None] * np.outer(direction, k)))

    def error(n):
        box = reference_fem.box_discretisation(Box((1.2, 0.8, 1.0)[:d]), n, element)
        body = make_discretisation(vaulted(box.points), box.cells, element) if bent else box
        assert body.curved == (bent and ELEMENTS[element].degree == 2)
        nodal = np.sin(body.points @ k)[:, None] * direction
        return np.sqrt(((Solution(body, nodal, law).stress(x) - wanted) ** 2).mean())

    assert np.log2(error(5) / error(10)) == pytest.approx(ELEMENTS[element].degree, abs=0.1)


def test_bad_questions_are_named():
    body = reference_fem.box_discretisation(Box((1.0, 1.0)), 2)
    u = np.zeros(body.points.shape)
    with pytest.raises(ProblemError, match="stress: the solution was made without a material"):
        Solution(body, u).stress([[0.5, 0.5]])
    with pytest.raises(ProblemError, match="must lie in the body"):
        Solution(body, u, Isotropic(1.0, 0.3)).stress([[1.5, 0.5]])
    with pytest.raises(ProblemError, match=r"shape \(2,\); give \(p, 2\)"):
        Solution(body, u, Isotropic(1.0, 0.3)).strain([0.5, 0.5])
    with pytest.raises(ProblemError, match=r"pressure: shape \(3,\); give \(9,\)"):
        Solution(body, u, Isotropic(1.0, 0.3), np.zeros(3))
