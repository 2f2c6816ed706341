"""What multipoles leave to exact integrals, by hand: it needs no library."""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.charges import multipole
from msvalidate.dielectric.charges.moments import coefficients, segment_lines


def test_near_pairs_are_all_those_within_reach_of_both_lengths_once():
    rng = np.random.default_rng(3)
    middle = rng.uniform(-1, 1, (40, 2)) @ np.array([1, 1j])
    length = rng.uniform(0.01, 0.37, 40)
    found = {(int(i), int(j)) for i, j in zip(*multipole._near_pairs(middle, length), strict=True)}
    expected = set()
    for i in range(40):
        for j in range(i + 1):
            if abs(middle[i] - middle[j]) <= multipole.NEAR * (length[i] + length[j]) / 2:
                expected.add((i, j) if length[i] >= length[j] else (j, i))
    assert 40 < len(expected) < 40 * 41 / 2, "some pairs are near, and some are not"
    assert found == expected


def test_gauss_points_and_corrections_are_the_exact_means(wavy):
    electrodes = wavy(12)
    start, along = segment_lines(electrodes)
    m = len(start)
    points = start[:, None] + np.array(multipole.NODES) * along[:, None]
    with np.errstate(divide="ignore"):
        apart = np.log(np.abs(points[:, None, :, None] - points[None, :, None, :]))
    apart[np.isinf(apart)] = 0.0  # a charge does not see itself
    summed = np.einsum("ijst,s,t->ij", apart, multipole.WEIGHTS, multipole.WEIGHTS)
    corrections = multipole._corrections(start, along).toarray()
    near = corrections != 0
    # Coefficients are of ln(r/extent), so that they do not depend on the unit of length.
    exact = np.log(electrodes.extent) - 2 * np.pi * coefficients(electrodes, 1.0, "galerkin")
    assert m < near.sum() < m * m
    np.testing.assert_allclose((summed + corrections)[near], exact[near], atol=1e-12)
