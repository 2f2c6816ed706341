"""Formulas in README and docs: each as it is printed, beside a number found another way.

What looks like a formula (`MARKS`) and is in no row of `formulas` fails. Pages made from results
(docs/studies, docs/verification.md) are left out: there a formula stands beside its number.
"""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import quad
from scipy.linalg import eigvalsh, toeplitz
from scipy.optimize import brentq, minimize_scalar

from msvalidate import Box, calibrate, fill, homogenise, patterns, spring_network
from msvalidate.simulators.bodies.laws import LAWS, lame, predicted
from msvalidate.springs.constants import waves
from msvalidate.springs.dynamics import spectrum
from msvalidate.springs.lattice import boundary_weights
from msvalidate.springs.network import internal_force
from msvalidate.springs.network.laws import volumes

ROOT = Path(__file__).resolve().parents[1]
FULL = ROOT / "reports" / "baseline" / "full"
PAGES = {p for way in ("*.md", "docs/*.md", "docs/decisions/*.md") for p in ROOT.glob(way)}
LEFT_OUT = {"CHANGELOG.md", "verification.md"}
MARKS = re.compile(
    r"√|[\w)]/\(|\([\w/]+ [-+] \w+\)|\d ?(?:mu|[κλμρω])\b"
    r"|(?<![\w.`\"/[-])[A-Za-zα-ω]{1,2}\d{0,4}′? = (?![\d.]+e)[\d.]*[A-Za-zα-ω]"
)
"""A root; a quotient by a bracket; a bracketed sum; a multiple of a Greek letter; a symbol set
equal to an expression in another one."""
SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"
EXACT = 1e-12
E, NU = 7.0, 0.37
MU, LAM = lame(E, NU)
READ = predicted(SMITH, E, NU)
ISOTROPIC = np.linalg.inv(np.array([[1, -NU, -NU], [-NU, 1, -NU], [-NU, -NU, 1]]) / E)
SHEET = ISOTROPIC[0, 1] - ISOTROPIC[0, 2] ** 2 / ISOTROPIC[2, 2]  # λ′ in plane stress
CHAIN = np.r_[2, -1, np.zeros(98)]  # of points of mass 1 and springs of 1 N/m, between walls
SYMBOLS = {
    "μ": MU,
    "μt": MU,
    "μh": MU,
    "λ": LAM,
    "λ′": SHEET,
    "ρ": 1,
    "ρh": 1,
    "ρth": 1,
    "t": 1,
    "h": 1,
}
PRIMED = {"μ′": READ.C[3, 3], "λ′": READ.C[0, 1], "E′": READ.E, "ν′": READ.nu}
BENT = np.array([[1.1, 0.2, 0.0], [0.0, 0.9, 0.1], [0.0, 0.0, 1.05]])


def square(k1, k2):
    return homogenise(patterns.square(), (k1, k2)).tensor


def entries(C):
    return {"C11": C[0, 0], "C12": C[0, 1], "C44": C[-1, -1], "C66": C[-1, -1], "C1212": C[-1, -1]}


def anisotropy(C):
    """Stiffness of the shear between two axes over that of the shear between their diagonals."""
    return C[-1, -1] / ((C[0, 0] + C[1, 1] - C[0, 1] - C[1, 0]) / 4)


def smith_energy():
    """Work of the law's stress along a straight path from rest, by Gauss's rule."""
    H = BENT - np.eye(3)
    at, weight = np.polynomial.legendre.leggauss(20)
    steps = [(LAWS[SMITH].stress(np.eye(3) + (1 + t) / 2 * H, MU, LAM) * H).sum() for t in at]
    at_rest = evaluated("μ/2(3 - 3 - ln(4)) + λ/2(3μ/(4λ))²", {"μ": MU, "λ": LAM})
    return 0.5 * weight @ steps + at_rest


def slowest(c):
    return np.linalg.eigvals([[0.0, 1.0], [-9.0, -c]]).real.max()


def springs(name, nu=NU):
    """Constants that are found for a lattice: by search, but for the square and the triangular."""
    pattern = getattr(patterns, name)()
    return calibrate(E, nu, pattern, "plane_stress" if pattern.dim == 2 else "solid")


def body(name, cells):
    pattern = getattr(patterns, name)()
    return fill(pattern, Box(tuple(cells * side for side in pattern.size)), cells)


def mass(name):
    return body(name, 3).point_volume.max()


def highest(name, nu=NU):
    """Highest frequency squared of an endless lattice, times the mass of a point."""
    pattern, found = getattr(patterns, name)(), springs(name, nu)
    return waves.highest_frequency(pattern, found.constants, found.volume)


def damping_ratio(beta, omega):
    """Damping ratio of a mode of frequency ω with stiffness-proportional damping β."""
    return -np.roots([1, beta * omega**2, omega**2]).real.max() / omega


def one_cell(name):
    """Highest frequency squared of a cell alone, times the mass of a point inside a body.

    No body of such cells has a higher one [Irons1971].
    """
    cell, found = body(name, 1), springs(name)
    network = spring_network(
        cell.points,
        cell.springs,
        np.array(found.constants)[cell.kind] * cell.factor * boundary_weights(cell, "shared"),
        mass=cell.point_volume,
        volumes=volumes.Volumes(cell.points, cell.cells, np.full(1, found.volume)),
    )
    return spectrum.highest_frequency(network) ** 2 * mass(name)


def evaluated(printed, values):
    """A formula's right side as it is printed, at values of its symbols."""
    code = re.sub(r"√(\d)", r"√(\1)", printed.rpartition(" = ")[2])
    code = code.replace("²", "**2").replace("³", "**3").replace("√", "sqrt")
    code = re.sub(r"(?<=[\d)])\s*(?=[(A-Za-zα-ω])", "*", code)
    for symbol in sorted(values, key=len, reverse=True):
        code = re.sub(rf"\b{symbol}\s*\(", f"{symbol}*(", code)
    code, names = code.replace("′", "_"), {k.replace("′", "_"): v for k, v in values.items()}
    return eval(code, {"sqrt": math.sqrt, "ln": math.log} | names)  # noqa: S307  our own docs


CELLS = pd.read_csv(FULL / "poisson/finite_size.csv").query("weights == 'equal' and cells == 1")
WAVES = pd.read_csv(FULL / "damping/wave.csv").query("cells == 400").set_index("sides")["speed_m_s"]
READING = pd.read_csv(FULL / "poisson/incompressible.csv").set_index("reading")
CUBIC = homogenise(patterns.cubic18(), (1.0, 2.0)).tensor
SPRING = spring_network([[0.0, 0.0], [2.0, 0.0]], [[0, 1]], [5.0])
CELL = volumes.Volumes([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]], [[0, 1, 2]], [5.0])
LONGER = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 1.0]])
GROWN = LONGER - CELL.points
TRIANGULAR = homogenise(patterns.triangular(), (1.0,)).tensor


@cache
def formulas():
    """Compute all rows in the tests that need them; some take a second."""
    return {  # printed -> values of its symbols, what it comes to by another way, relative error
        "k2/(2k1 + k2)": (CELLS[["k1", "k2"]].to_dict("series"), CELLS["nu_springs"], EXACT),
        "k2/(k1 + k2)": ({"k1": 2, "k2": 3}, square(2, 3)[0, 1] / square(2, 3)[0, 0], EXACT),
        "k2 = k1/2": ({"k1": 3}, brentq(lambda k: anisotropy(square(3, k)) - 1, 1, 2), 1e-9),
        "k2 = 2k1": ({"k1": 1}, float(READING.loc["the report, k2 = 2 k1", "k2_over_k1"]), EXACT),
        "c = 2ω": ({"ω": 3}, minimize_scalar(slowest, (1, 5, 9), tol=1e-12).x, 1e-6),
        "√(C11/ρ)": (entries(square(1, 0.5)) | {"ρ": 1}, WAVES["held"], 1e-3),
        "√(E2/ρ)": ({"E2": 1 / np.linalg.inv(square(1, 0.5))[0, 0], "ρ": 1}, WAVES["free"], 4e-3),
        "A = 2 C44/(C11 - C12)": (entries(CUBIC), anisotropy(CUBIC), EXACT),
        "2 C66/(C11 - C12)": (entries(square(1, 2)), anisotropy(square(1, 2)), EXACT),
        "C1122 = C1212": (entries(TRIANGULAR), TRIANGULAR[0, 1], EXACT),
        "k (L - L0)": ({"k": 5, "L": 3, "L0": 2}, internal_force(SPRING, LONGER[:2])[0, 0], EXACT),
        "κ(V/V0 - 1)² V0/2": ({"κ": 5, "V": 1.5, "V0": 1}, volumes.energy(CELL, GROWN), EXACT),
        "1/(4πεr)": (  # the field of a unit charge is its flux through a sphere
            {"πεr": math.pi * 2 * 3},
            quad(lambda r: 1 / 2 / (4 * math.pi * r**2), 3, np.inf)[0], 1e-9
        ),
        "Σσ²/(2ε)": (  # of one face: slope of the energy Q²/2C in the gap d, C = ε/d
            {"Σσ": 3, "ε": 2}, np.diff([3**2 / (2 * 2 / d) for d in (1, 2)])[0], EXACT
        ),
        "lam - 2 mu/3": ({"lam": E / 3 / (1 - 2 * NU), "mu": MU}, LAM, EXACT),  # of a bulk modulus
        "W = μ/2 (I - 3 - ln(I + 1)) + λ/2 (J - 1 - 3μ/(4λ))²": (
            {"μ": MU, "λ": LAM, "I": (BENT**2).sum(), "J": np.linalg.det(BENT)},
            smith_energy(), EXACT
        ),
        "μ′ = 3μ/4": ({"μ": MU}, READ.C[3, 3], EXACT),
        "λ′ = λ - 5μ/8": ({"μ": MU, "λ": LAM}, READ.C[0, 1], EXACT),
        "E′/E = 3(54ν - 3)/(4(28ν + 2)(1 + ν))": ({"ν": NU}, READ.E / E, EXACT),
        "ν′ = (26ν - 5)/(28ν + 2)": ({"ν": NU}, READ.nu, EXACT),
        "4μ′/3": (PRIMED, MU, EXACT),
        "λ′ + 5μ′/6": (PRIMED, LAM, EXACT),
        "ν = (5 + 2ν′)/(26 - 28ν′)": (PRIMED, NU, EXACT),
        "E = 4E′(1 + ν)/(3(1 + ν′))": (PRIMED | {"ν": NU}, E, EXACT),
        # docs/choosing-constants.md
        "4μ/3": ({"μ": READ.C[3, 3]}, MU, EXACT),
        "λ + 5μ/6": ({"μ": READ.C[3, 3], "λ": READ.C[0, 1]}, LAM, EXACT),
        "E/(2(1 + ν))": ({"E": E, "ν": NU}, (ISOTROPIC[0, 0] - ISOTROPIC[0, 1]) / 2, EXACT),
        "λ = Eν/((1 + ν)(1 - 2ν))": ({"Eν": E * NU, "ν": NU}, ISOTROPIC[0, 1], EXACT),
        "λ′ = Eν/(1 - ν²)": ({"Eν": E * NU, "ν": NU}, SHEET, EXACT),
        "λ + 2μ": (SYMBOLS, ISOTROPIC[0, 0], EXACT),
        "E = μ(3λ + 2μ)/(λ + μ)": (SYMBOLS, E, EXACT),
        "2μt": (SYMBOLS, springs("square").constants[0], EXACT),
        "μt": (SYMBOLS, springs("square").constants[1], EXACT),
        "(λ′ - μ)t": (SYMBOLS, [springs(n).volume for n in ("square", "triangular")], EXACT),
        "4μt/√3": (SYMBOLS, springs("triangular").constants[0], EXACT),
        "2√3(λ′ - μ)t": (SYMBOLS, springs("honeycomb").constants[0], 1e-9),
        "2μt/√3": (SYMBOLS, springs("honeycomb").constants[1], 1e-9),
        "μh": (SYMBOLS, [*springs("cubic18").constants, springs("fcc").constants[0]], EXACT),
        "11μh/7": (SYMBOLS, springs("cubic26").constants[0], EXACT),
        "3μh/7": (SYMBOLS, springs("cubic26").constants[1:], EXACT),
        "3μh/2": (SYMBOLS, springs("bcc").constants[0], EXACT),
        "μh/4": (SYMBOLS, springs("fcc").constants[1], EXACT),
        "λ - μ": (
            SYMBOLS, [springs(n).volume for n in ("cubic18", "cubic26", "bcc", "fcc")], EXACT
        ),
        "ρth²": (SYMBOLS, mass("square"), EXACT),
        "√3ρth²/2": (SYMBOLS, mass("triangular"), EXACT),
        "3√3ρth²/4": (SYMBOLS, mass("honeycomb"), EXACT),
        "ρh³/2": (SYMBOLS, mass("bcc"), EXACT),
        "ρh³/4": (SYMBOLS, mass("fcc"), EXACT),
        "4(λ′ + 2μ)t": (SYMBOLS, highest("square"), 1e-9),
        "8√3μt": ({"μt": E / 2 / (1 + 1 / 3)}, highest("triangular", 1 / 3), 1e-9),
        "4(λ + 2μ)h": (SYMBOLS, [highest("cubic18"), highest("cubic26")], 1e-9),
        "12μh": ({"μh": E / 2 / (1 + 1 / 4)}, highest("bcc", 1 / 4), 1e-9),
        "4(λ + μ)h": (SYMBOLS, highest("bcc"), 1e-9),
        "9μh": ({"μh": E / 2 / (1 + 1 / 4)}, highest("fcc", 1 / 4), 1e-9),
        "(4λ + μ)h": (SYMBOLS, highest("fcc"), 1e-9),
        # By XPBD of compliance 1/k, one iteration; by the roots of a damped mode.
        "k/(k + m/(2τ²))": ({"k": 7, "m": 3, "τ": 0.5}, (2 / 3) / (2 / 3 + 1 / 7 / 0.25), EXACT),
        "β = 2ζ/ω": (
            {"ζ": 0.05, "ω": 3}, brentq(lambda b: damping_ratio(b, 3) - 0.05, 0, 0.1), 1e-9
        ),
        "c = √((λ + 2μ)/ρ)": (SYMBOLS, springs("cubic18").tensor[0, 0] ** 0.5, EXACT),
        "h/√(2(λ′ + μ)/ρ)": (SYMBOLS, 2 / one_cell("square") ** 0.5, 1e-9),
        "h/√((3λ + 2μ)/ρ)": (SYMBOLS, 2 / one_cell("cubic18") ** 0.5, 1e-9),
        "c = √(EA/w)": (
            {"EA": 3, "w": 2}, eigvalsh(toeplitz(CHAIN * 3 / 2)).max() ** 0.5 / 2, 1e-3
        ),
    }  # fmt: skip


def test_a_formula_is_what_it_says():
    for printed, (values, expected, error) in formulas().items():
        value = evaluated(printed, values)
        np.testing.assert_allclose(value, expected, rtol=error, err_msg=printed)


def left(text):
    """What looks like a formula in a page and is in no row."""
    text = re.sub(r"```.*?```|\]\([^)]*\)", " ", text, flags=re.DOTALL)
    for printed in sorted(formulas(), key=len, reverse=True):
        letters = r"\s*".join(map(re.escape, re.sub(r"\s", "", printed)))
        text = re.sub(rf"(?<![\w/]){letters}(?![\w/(^²])", "¶", text)
    return [text[max(0, m.start() - 20) : m.end() + 20] for m in MARKS.finditer(text)]


def test_every_formula_in_the_pages_is_in_a_row():
    found = {
        page.name: left(page.read_text("utf-8")) for page in PAGES if page.name not in LEFT_OUT
    }
    assert {name: lost for name, lost in found.items() if lost} == {}, "give it a row of formulas()"


def test_a_formula_without_a_row_is_noticed():
    assert len(left("√2 k; k3/(k1 + k2); c = 3ω; k2 = 2k1/3; but `path=` and E = 70e9 Pa")) == 4
