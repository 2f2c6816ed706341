"""The springs that a case's run has: constants of its own network, steps that hold, damping."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.compare.body_advice import advise_body, body_lines
from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.problem import (
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Problem,
    Region,
    SolverError,
    Support,
    Traction,
)
from msvalidate.problem.records import replace
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS

EXAMPLES = Path(__file__).parents[4] / "examples"
SHEET = Box((0.37, 0.148))


def sheet(nu=0.4, **options):
    pull = Traction(SHEET.side("right"), (0.0, -1e3))
    held = Support(SHEET.side("left"), (0.0, 0.0))
    law = Isotropic(2.8e9, nu, "plane_stress", 1200.0, thickness=0.2)
    return Case(Problem(SHEET, law, (held,), (pull,)), **options)


def cut():
    return replace(read_case(EXAMPLES / "bracket.toml"), spacing=0.004)


@pytest.mark.parametrize("scheme", ["leapfrog", "euler_cromer"])
@pytest.mark.parametrize("case", [sheet(cells=4), cut()], ids=["filled", "cut"])
def test_a_step_holds_to_its_limit_and_not_beyond(case, scheme):
    answer = solve_springs(case, case.spacing or 0.037)
    (found,) = advise_body(case, answer)
    network = replace(answer.network, force=0 * answer.network.force)
    noise = 1e-6 * answer.spacing * np.random.default_rng(0).normal(size=network.points.shape)
    noise[network.fixed] = 0.0

    def grown(part):
        state = State(network.points + noise, 0 * noise)
        each = INTEGRATORS[scheme], part * found.limits[scheme], 100, found.damping.rate
        try:
            end = motion(network, state, *each, warn=False).position
        except SolverError:  # beyond all numbers
            return np.inf
        return np.abs(end - network.points).max() / np.abs(noise).max()

    assert grown(0.98) < 10
    assert grown(1.02) > 1000


def test_words_and_numbers_are_those_of_the_network():
    case = sheet(cells=4)
    answer = solve_springs(case, 0.037)
    (found,) = advise_body(case, answer)
    inside = answer.network.mass.max()
    assert found.mass == pytest.approx(inside) == pytest.approx(1200 * 0.2 * 0.037**2)
    assert found.kinds[0].constant == pytest.approx(answer.network.stiffness.max())
    mu = 2.8e9 / 2.8
    assert [kind.constant for kind in found.kinds] == pytest.approx([2 * mu * 0.2, mu * 0.2])
    # κ = (λ′ - μ)t with λ′ = Eν/(1 - ν²)
    assert found.volume == pytest.approx((2.8e9 * 0.4 / 0.84 - mu) * 0.2)
    assert found.volume == pytest.approx(answer.network.volumes.stiffness[0])
    said = "\n".join(body_lines((found,)))
    assert "by the slowest motion that this load excites" in said
    assert "count 1/2" in said
    (other,) = advise_body(cut(), solve_springs(cut(), 0.004))
    assert "cut cells count by the part in the body" in other.boundary


def test_constants_of_a_case_are_what_they_make_and_have_no_formula():
    case = sheet(1 / 3, cells=4, constants=(1e6, 2e6))
    (found,) = advise_body(case, solve_springs(case, 0.037))
    assert (found.nu, found.zener) == pytest.approx((2 / 3, 4.0))
    assert [kind.formula for kind in found.kinds] == ["", ""]
    assert "by direction unequal (Zener ratio 4)" in body_lines((found,))[0]


def test_why_there_is_no_damping():
    plain = sheet(1 / 3, cells=4)
    case = replace(plain, problem=replace(plain.problem, loads=()))
    (found,) = advise_body(case, solve_springs(case, 0.037))
    assert found.damping is None
    assert "no damping: quickest damping: no load" in body_lines((found,))[-1]


def test_a_honeycomb_is_compared_on_its_own_lattice_alone():
    box = Box((7 * math.sqrt(3), 12.0))
    pull, held = Traction(box.side("right"), (1e3, 0.0)), Support(box.side("left"), (0.0, 0.0))
    law = Isotropic(1e7, 0.4, "plane_stress")
    case = Case(Problem(box, law, (held,), (pull,)), lattice="honeycomb", spacing=1.0)
    found = compare_case(case)
    assert np.isfinite(found.rows[0].error)
    assert len(found.springs) == 1
    assert found.advice[0].lattice == "honeycomb"


def test_regions_and_edges_have_lines_of_their_own():
    zones = read_case(EXAMPLES / "bimaterial.toml")
    first, second = advise_body(zones, solve_springs(zones, 0.1))
    assert second.kinds[0].constant == pytest.approx(10 * first.kinds[0].constant)
    assert body_lines((first, second))[-1].startswith("region 1: k1 = 750000 N/m")
    mesh = Mesh(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), np.array([[0, 1, 2, 3]]), "quad")
    law = Isotropic(1e6, 1 / 3, "plane_stress")
    held, pull = Support(Region((0.0, None)), (0.0, 0.0)), PointForce((1.0, 1.0), (1.0, 0.0))
    case = Case(Problem(mesh, law, (held,), (pull,)), lattice="mesh edges")
    answer = solve_springs(case, 1.0)
    (found,) = advise_body(case, answer)
    assert found.kinds[0].constant in answer.network.stiffness
    assert "E·V/L²" in body_lines((found,))[1]
