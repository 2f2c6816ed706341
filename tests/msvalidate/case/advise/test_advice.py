"""Springs advised for a material: formulas, frequencies, words, and the command line."""

from __future__ import annotations

import json
import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case import advise as advise_package
from msvalidate.case.advise.advice import (
    advice_lines,
    advice_of,
    advice_record,
    advise,
)
from msvalidate.case.advise.nearest_ratio import change_of_blocks
from msvalidate.cli.program import main
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, Support
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.routes import calibrate_by_route
from msvalidate.springs.constants.stiffness import springs_ratio
from msvalidate.springs.dynamics import spectrum
from msvalidate.springs.dynamics.damping import Damping
from msvalidate.springs.lattice import boundary_weights, fill
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate.springs.network import tangent
from tests.registries import ISOTROPIC
from tests.table import stored_rows, table

SPACING, THICKNESS = 0.37 / 5, 0.2
ENGINES = Path(advise_package.__file__).with_name("engines.toml")
STATES = {2: ("plane_stress", "plane_strain"), 3: ("solid",)}


def material(state, nu, E=2.8e9):
    return Isotropic(E, nu, state, 1234.0, 1.0 if state == "solid" else THICKNESS)


def evaluated(formula, values):
    """A formula as it is printed: factors side by side are multiplied."""
    words = re.findall(r"\d+|√\d+|λ′|[μλth]|[()/·-]", formula)
    assert "".join(words) == formula.replace(" ", "")
    python = ""
    for word, last in zip(words, [".", *words], strict=False):
        gap = "*" if python and word not in ")/·-" and last not in "(/·-" else ""
        root = f"math.sqrt({word[1:]})" if word[0] == "√" else word.replace("·", "*")
        python += gap + root.replace("λ′", "λ")
    return eval(python, {"math": math, **values})  # noqa: S307  of our own table


@table("lattice, nu", [(name, nu) for name in ISOTROPIC for nu in (0.3, 0.4)])
def test_formulas_are_what_the_calibration_has(lattice, nu):
    for state in STATES[all_patterns()[lattice]().dim]:
        found = material(state, nu)
        lame = found.E * nu / (1 - nu**2 if state == "plane_stress" else (1 + nu) * (1 - 2 * nu))
        values = {"λ": lame, "μ": found.E / 2 / (1 + nu), "t": THICKNESS, "h": SPACING}
        try:
            own = calibrate_by_route(found, all_patterns()[lattice](), SPACING, None)
        except ProblemError:
            assert lattice == "honeycomb"
            assert lame <= values["μ"] * (1 + 1e-9)
            continue
        advice = advice_of(found, lattice, own, 1.0, "it")
        got = [kind.constant for kind in advice.kinds]
        told = [evaluated(kind.formula, values) for kind in advice.kinds]
        assert got == pytest.approx(told, rel=1e-7)
        kappa = evaluated(advice.volume_formula, values) if advice.volume_formula else 0.0
        assert advice.volume == pytest.approx(kappa, rel=1e-9)
        assert (advice.E, advice.nu) == pytest.approx((found.E, nu), rel=1e-9)
        if all_patterns()[lattice]().formulas.zero_length:
            own = calibrate_by_route(found, all_patterns()[lattice](), SPACING, "neo-Hookean")
            told = [
                evaluated(k.formula, values) for k in advice_of(found, lattice, own, 1, "").kinds
            ]
            assert own.constants == pytest.approx(told, rel=1e-9)


@pytest.mark.parametrize("lattice", ISOTROPIC)
def test_steps_are_those_of_bodies(lattice):
    # By the tangent of a body with a side held, and by steps of leapfrog in plain numbers.
    pattern = all_patterns()[lattice]()
    found = material(STATES[pattern.dim][-1], 0.4)
    advice = advise(found, lattice, SPACING)
    calibration = calibrate_by_route(found, pattern, SPACING, None)
    own = []
    for cells in ((2,) * pattern.dim, (3,) * pattern.dim, (5, *(2,) * (pattern.dim - 1))):
        box = Box(tuple(SPACING * n * e for n, e in zip(cells, pattern.size, strict=True)))
        hold = Support(box.side("left"), (0.0,) * pattern.dim)
        network = lattice_network(
            Problem(box, found, (hold,)), fill(pattern, box, cells), calibration
        )
        own.append(spectrum.highest_frequency(network))
    assert max(own) <= 1.008 * advice.omega  # of BLOCK
    assert max(own) >= 0.97 * advice.omega  # the side that is held is one of several
    free = np.flatnonzero(~network.fixed.ravel())
    K = tangent(network, network.points).toarray()[np.ix_(free, free)]
    mass = np.repeat(network.mass, pattern.dim)[free]
    largest = []
    for part in (0.98, 1.02 * advice.omega / own[-1]):
        h, v = part * advice.limits["leapfrog"], 0.0
        u = np.random.default_rng(0).normal(size=len(free))
        for _ in range(400):
            v = v - h * (K @ u) / mass
            u = u + h * v
        largest.append(np.abs(u).max())
    assert largest[0] < 100
    assert largest[1] > 1e4


def test_what_is_told_of_the_boundary_is_done():
    for dim, lattice, parts in ((2, "square", {0.5, 1}), (3, "cubic18", {0.25, 0.5, 1})):
        body = fill(all_patterns()[lattice](), Box((1.0,) * dim), 3)
        assert set(boundary_weights(body, "shared").tolist()) == parts
        told = advise(material(STATES[dim][0], 0.3), lattice, 1.0).boundary
        assert ("1/4" in told) == (dim == 3)
        assert "1/2" in told


def test_damping_is_told_and_shortens_euler_cromer():
    found = material("plane_stress", 0.4)
    calibration = calibrate_by_route(found, all_patterns()["square"](), SPACING, None)
    omega, rate = 1000.0, 600.0
    advice = advice_of(found, "square", calibration, omega, "it", Damping(rate, 0.01, 300.0, 1e-3))
    zeta = rate / 2 / omega
    closed = 2 * (math.sqrt(1 + zeta**2) - zeta) / omega
    assert advice.limits == pytest.approx({"leapfrog": 2 / omega, "euler_cromer": closed})
    lines = advice_lines(advice)
    assert len(lines) == 5
    assert "c = 600 1/s, by the slowest motion that this load excites (300 rad/s)" in lines[-1]
    assert (
        "not by E and nu: within 0.1 % of rest after 0.01 s, 6 steps" in lines[-1]
    )  # of 0.9 · 2/ω
    assert json.loads(json.dumps(advice_record(advice)))["steps_to_rest"] == 6


@pytest.mark.parametrize(("zener", "unequal"), [(0.5, True), (1.0, False), (2.0, True)])
def test_unequal_directions_are_told(zener, unequal):
    advice = replace(advise(material("plane_strain", 0.25), "square", 1.0), zener=zener)
    assert ("by direction unequal" in advice_lines(advice)[0]) is unequal


def test_a_price_is_in_proportion_to_the_change_of_the_ratio():
    found = Isotropic(1.0, 0.3, "plane_strain")
    assert springs_ratio(found) == 0.25
    whole = change_of_blocks(found, 0.25)
    assert change_of_blocks(found, 0.275) == pytest.approx(tuple(e / 2 for e in whole), rel=0.15)


def test_every_program_has_its_number(capsys):
    # By hand, of k = μh: μ = E/2.5 at nu = 1/4, h = 2.
    for engine, axes, said in (
        (
            "springs",
            "--step 1",
            (
                "m/(2*dt**2)) = 0.333333 1",
                "k/2 = 4",
                "k = 8 ",
                "k*L = 16, 22.6274 N",
                "1/k = 0.125 m/N",
            ),
        ),
        ("cells", "", ("E = 10 Pa", "mu = 4 Pa", "E/rho = 2.5 Pa")),
        ("cells", "--thickness .5", ("mu*t = 2 N/m", "lam2*t = 1.33333 N/m")),
    ):
        words = f"advise --E 10 --nu .25 --density 4 --spacing 2 --engine {engine} {axes}"
        assert main(words.split()) == 0
        out = capsys.readouterr().out
        assert all(each in out for each in said)
        assert ("triangles  " in out) == ("thickness" in axes)
    rows = tomllib.loads(ENGINES.read_text(encoding="utf-8"))["engine"]
    assert {row["factor"] for row in rows} == {
        "",
        "k/2",
        "k",
        "k*L",
        "1/k",
        "E",
        "mu",
        "E/rho",
        "mu*t",
        "lam2*t",
        "k/(k + m/(2*dt**2))",
    }


@table("words, said", stored_rows("advise_commands"))  # fmt: skip
def test_refusals_are_one_line(words, said, capsys):
    try:
        code = main(["advise", *words.split()])
    except SystemExit as end:
        code = end.code
    lines = capsys.readouterr().err.splitlines()
    assert (code, len(lines)) == (2, 1)
    assert said in lines[0]


def test_the_command_says_its_numbers_and_what_it_took(capsys):
    sheet = "advise --E 2.8GPa --nu .4 --thickness 6mm --spacing 2mm"
    assert main([*sheet.split(), "--engine", "springs", "-v"]) == 0
    out = capsys.readouterr().out
    assert "plane_stress (default; another by --state)" in out
    assert "springs alone have nu = 0.3333 (honeycomb: others too)" in out
    assert "k1 = 1.26e+07 N/m = 2μt along the axes" in out  # 2 t E/(2 (1 + 1/3))
    assert "k2 = 2 k1, k1 1 times the right one" in out
    assert main([*sheet.split(), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert [each["lattice"] for each in record["lattices"]] == ["square", "triangular", "honeycomb"]
    assert record["lattices"][0]["kinds"][0]["constant"] == pytest.approx(1.2e7)
    assert list(record["cannot"]) == ["square4"]
