"""`springs.bodies.toughness`: critical stretches by both rules."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from msvalidate.problem import ProblemError
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.toughness import CrackPatch, critical_stretch, starts
from msvalidate.springs.lattice import patterns
from msvalidate.springs.network import spring_network

SQUARE, TRIANGULAR = (2.0, 1.0), (4 / math.sqrt(3),)


def antiplane(radius):
    """Springs along a square lattice that resist its points' moves out of its plane.

    Moves are along one axis, on which every point has a place of its own.
    """
    n = radius + 2
    i, j = np.meshgrid(*[np.arange(-n, n + 1)] * 2, indexing="ij")
    x = np.column_stack([i.ravel(), j.ravel() + 0.5])
    number = np.arange(len(x)).reshape(i.shape)
    along, up = (number[:-1], number[1:]), (number[:, :-1], number[:, 1:])
    springs = np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in (along, up)])
    a, b = x[springs].transpose(1, 0, 2)
    over = a[:, 1] * b[:, 1] < 0
    behind, rim = over & (a[:, 0] < -0.3), np.hypot(*x.T) >= radius
    w = 2 * np.sqrt(np.hypot(*x.T) / (2 * np.pi)) * np.sin(np.arctan2(x[:, 1], x[:, 0]) / 2)
    place = np.column_stack([x[:, 0] + (2 * n + 3) * x[:, 1], 0 * w])
    held = np.column_stack([rim, np.ones(len(x), dtype=bool)])
    network = spring_network(
        place, springs, np.where(behind, 0.0, 1.0), fixed=held,
        displacement=np.where(held, np.column_stack([w, 0 * w]), 0.0),
    )  # fmt: skip
    stretch = np.where(rim[springs].all(axis=1), np.inf, 1 / network.distance)
    ahead = over & ~behind
    return CrackPatch(network, stretch, np.where(ahead, a[:, 0], np.nan), ahead & (a[:, 0] < 0.7))


def test_the_antiplane_square_lattice_has_its_closed_form():
    """1 + √2 [Slepyan2002]; G = K²/2μ, and a spring holds 1/2 when it breaks."""
    (K,) = starts(antiplane)
    assert pytest.approx(1 + math.sqrt(2), abs=1e-3) == K**2


@pytest.mark.parametrize(
    ("pattern", "k", "direction", "first", "growth"),
    [
        (patterns.square, SQUARE, (1, 0), 2.0576, 2.3655),
        (patterns.square, SQUARE, (0, -1), 2.0576, 2.3655),
        (patterns.triangular, TRIANGULAR, (1, 0), 3.748, 3.748),
        (patterns.triangular, TRIANGULAR, (1, math.sqrt(3)), 3.748, 3.748),
    ],
)
def test_growth_in_the_field_of_a_crack(pattern, k, direction, first, growth):
    """Values of an independent program, from three sizes."""
    found = critical_stretch(pattern(), k, 1.0, direction=direction)
    assert [found.first, found.ratio] == pytest.approx([first, growth], abs=5e-3)
    own = critical_stretch(pattern(), k, 1.0, direction=direction, rule="springs")
    assert (own.critical_stretch / found.critical_stretch) ** 2 == pytest.approx(found.ratio)


@pytest.mark.parametrize(
    ("pattern", "k", "angle", "energy"),
    [
        (patterns.square, SQUARE, 0.0, 3.0),
        (patterns.square, SQUARE, 45.0, 2 * math.sqrt(2)),
        (patterns.square, SQUARE, 22.5, 3.1543),
        (patterns.triangular, TRIANGULAR, 0.0, 4 / math.sqrt(3)),
        (patterns.triangular, TRIANGULAR, 90.0, 8 / 3),
    ],
)
def test_what_springs_across_hold(pattern, k, angle, energy):
    way = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    found = critical_stretch(pattern(), k, 1.0, direction=way, rule="springs")
    assert found.critical_stretch**-2 == pytest.approx(energy, rel=1e-4)
    assert found.ratio == 1


def test_it_falls_with_the_root_of_the_spacing_whatever_the_thickness():
    by = []
    for spacing, thick in ((1.0, 1.0), (0.37, 0.2), (370.0, 200.0)):
        E = 2e5 * (1e-6 if spacing > 1 else 1)
        made = calibrate(E, 1 / 3, patterns.triangular(), thickness=thick, spacing=spacing)
        G_c = 3.0 * (1e-3 if spacing > 1 else 1)
        by.append(critical_stretch(patterns.triangular(), made, G_c).critical_stretch)
    assert by[1] / by[0] == pytest.approx(0.37**-0.5, rel=1e-9)
    assert by[2] == pytest.approx(by[1], rel=1e-9)  # the same in mm, MPa, N/mm
    stiff = critical_stretch(patterns.triangular(), (1e14,), 1e14)
    soft = critical_stretch(patterns.triangular(), (1e-6,), 1e-6)
    assert stiff.critical_stretch == pytest.approx(soft.critical_stretch, rel=1e-9)


def test_one_clear_line():
    square = patterns.square()
    other = calibrate(1.0, 0.4, square)
    for words, given in (
        ("make no isotropic solid (Zener ratio 2", (square, (1.0, 1.0), 1.0)),
        ("it leaves its plane, for the spring from", (square, SQUARE, 1.0, (1, 1))),
        ("along no row of the square lattice", (square, SQUARE, 1.0, (1, 0.3))),
        ("direction: (0, 0)", (square, SQUARE, 1.0, (0, 0))),
        ("cells beside the springs, which do not break; take square-8", (square, other, 1.0)),
        ("G_c: 0.0 J/m²", (square, SQUARE, 0.0)),
        ("critical stretch of a lattice in space", (patterns.cubic18(), (1.0, 1.0), 1.0)),
        ("give 2, one a kind", (square, (1.0,), 1.0)),
    ):
        pattern, k, G_c, *way = given
        with pytest.raises(ProblemError, match=re.escape(words)):
            critical_stretch(pattern, k, G_c, **({"direction": way[0]} if way else {}))
