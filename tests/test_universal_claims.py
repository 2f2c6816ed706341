"""Universal claims about results: each is sampled at random, or names its sample.

A claim over all values of a parameter is not shown by the few values of a table. The scan reads
where results are stated: README.md, docs/findings.md and docs/report.md, the findings of
docs/studies, what the ledger computed, the sentences of simulators' verdicts, and what studies
expect. Of these it takes the sentences that have

- *any*, *always*, *never*, *wherever* or *whatever*;
- *every* or *all* before a parameter (`PARAMETERS`): *every size*, *all ratios*.

*Every* or *all* before objects counts the members of one body or table (all springs, every study);
the table itself shows these. Manuals instruct and are not scanned. A sentence that is taken must
have a phrase of tests/universal_claims.toml: with the test that draws the parameter at random, or
with a reason why it is no claim about results. Otherwise the sentence is to name its sample.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.case.case import Case, spacing_of
from msvalidate.case.springs import solve_springs
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import isotropic_moduli
from msvalidate.dynamics.integrators import INTEGRATORS
from msvalidate.dynamics.step_limits import one_step_matrix
from msvalidate.lattice import fill, patterns, square
from msvalidate.network import Network
from msvalidate.problem import Box, Isotropic, Mesh, Problem, Region, Support, Traction
from msvalidate.statics.equilibrium import equilibrium
from reference_fem.body import solve_problem
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

ROOT = Path(__file__).resolve().parents[1]
ROWS = tomllib.loads((ROOT / "tests" / "universal_claims.toml").read_text("utf-8"))["claim"]
PARAMETERS = (
    "angle body cube depth direction distance fineness halving height length load mesh number "
    "place plate pressure rate ratio refinement rule seed size spacing step strain stretch time "
    "turn voltage"
)
UNIVERSAL = re.compile(
    r"\b(?:any|anything|always|never|wherever|whenever|whatever)\b|\b(?:every|all)\*? (?:"
    + PARAMETERS.replace(" ", "|")
    + r")(?:s|es)?\b",
    re.IGNORECASE,
)
RESULTS = ("found", "measure", "if", "topic")
"""Keys of the ledger that state what was found; others quote the report or give a theory."""


def texts() -> Iterator[tuple[str, str]]:
    """Places and texts that state results."""
    for name in ("README.md", "docs/findings.md", "docs/report.md"):
        yield name, re.sub(r"```.*?```", "", (ROOT / name).read_text("utf-8"), flags=re.DOTALL)
    for page in sorted(ROOT.glob("docs/studies/*.md")):
        findings = re.search(r"## Findings\n(.*?)\n## ", page.read_text("utf-8"), re.DOTALL)
        yield page.name, findings[1] if findings else ""
    for name, keys in (("studies/claims/ledger.toml", RESULTS),
                       ("msvalidate/simulators/verdict/sentences.toml", ())):  # fmt: skip
        content = tomllib.loads((ROOT / name).read_text("utf-8"))
        yield from ((name, text) for text in leaves(content, keys))
    for module in sorted(ROOT.glob("studies/**/*.py")):
        text = ast.get_docstring(ast.parse(module.read_text("utf-8"))) or ""
        expected = re.search(r"^Expected +(.*?)(?=\n\S|\n\n|\Z)", text, re.DOTALL | re.MULTILINE)
        yield str(module.relative_to(ROOT)), expected[1] if expected else ""


def leaves(content: object, keys: tuple[str, ...], key: str = "") -> Iterator[str]:
    """Texts of some keys, or of all."""
    if isinstance(content, dict):
        for name, value in content.items():
            yield from leaves(value, keys, name)
    elif isinstance(content, list):
        for value in content:
            yield from leaves(value, keys, key)
    elif isinstance(content, str) and (not keys or key in keys):
        yield content


def universal(text: str) -> list[str]:
    """Sentences, parts at semicolons and cells of tables that claim something universally."""
    quoted = re.sub(r"“[^”]*”", "", text)
    parts = re.split(r"(?<=[.;?!])\s+|\n\n|\n(?=[-|#])|\s\|\s", quoted)
    return [" ".join(part.split()) for part in parts if UNIVERSAL.search(" ".join(part.split()))]


def test_every_universal_claim_is_sampled_or_reworded():
    used, lost = set(), []
    for name, text in texts():
        for sentence in universal(text):
            phrases = {row["phrase"] for row in ROWS if row["phrase"] in sentence}
            used |= phrases
            if not phrases:
                lost.append(f"{name}: {sentence}")
    assert lost == []
    assert {row["phrase"] for row in ROWS} - used == set()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["phrase"])
def test_every_row_has_a_test_that_draws_parameters_or_a_reason(row):
    if "reason" in row:
        assert len(row["reason"].split()) >= 4
        return
    path, _, name = row["test"].partition("::")
    module = ast.parse((ROOT / "tests" / path).read_text("utf-8"))
    (function,) = (n for n in ast.walk(module) if isinstance(n, ast.FunctionDef) and n.name == name)
    assert re.search(r"\brng\b|default_rng|\bgiven\b", ast.unparse(function))


@pytest.mark.parametrize(
    "sentence",
    [
        "In square-8 it follows the nearest row at any turn.",
        "It runs along rows, wherever it begins.",
        "The ratio is 1/3 at every size.",
        "It is right at all ratios.",
        "| strength | the crack never leaves its row |",
    ],
)
def test_the_scan_takes_universal_claims(sentence):
    assert len(universal(f"First. {sentence} Last; all springs, every study.")) == 1


@pytest.fixture
def rng(request):
    """Generator of a test's parameters: another of each repetition."""
    return np.random.default_rng(request.param)


draws = pytest.mark.parametrize("rng", range(6), indirect=True)


def pulled(box: Box, law: Isotropic, pull: float) -> Problem:
    """A bar pulled by a traction (Pa), free to narrow."""
    far, d = box.size[0], box.dim
    others = [[None] * axis + [0.0] + [None] * (d - 1 - axis) for axis in range(d)]
    rollers = tuple(Support(Region(tuple(each)), tuple(each)) for each in others)
    load = Traction(Region((far, *[None] * (d - 1))), (pull, *[0.0] * (d - 1)))
    return Problem(box, law, rollers, (load,))


def stretches(network: Network, box: Box) -> tuple[float, float]:
    """Strain along a pulled bar and across it."""
    u = equilibrium(network).displacement
    far = (network.points > np.array(box.size) * (1 - 1e-9)).all(axis=1)
    along, across, *_ = u[far][0] / box.size
    return along, across


@draws
def test_a_volume_energy_gives_the_ratio_that_is_asked_for(rng):
    """A bar of whole squares has the material's strain in both directions, to rounding."""
    state = str(rng.choice(["plane_stress", "plane_strain"]))
    law = Isotropic(
        float(10 ** rng.uniform(3, 9)), float(rng.uniform(-0.9, 0.4999)), state, 1e3, 0.2
    )
    counts, side = tuple(int(n) for n in rng.integers(1, 9, 2)), rng.uniform(1e-3, 1.0)
    box = Box(tuple(side * n for n in counts))
    lattice = square(box, counts)
    constants = calibrate(law.E, law.nu, lattice, state, thickness=0.2, route="volume energy")
    pull = law.E * 1e-9
    along, across = stretches(lattice_network(pulled(box, law, pull), lattice, constants), box)
    plane = state == "plane_strain"
    assert along == pytest.approx(1e-9 * (1 - plane * law.nu**2), rel=1e-6)
    assert -across / along == pytest.approx(law.nu / (1 - plane * law.nu), rel=1e-6)


@draws
def test_shared_springs_have_the_ratio_of_an_endless_lattice(rng):
    """Squares whose shared springs count twice have the report's ratio instead."""
    pattern = patterns.square() if rng.random() < 0.5 else patterns.cubic18()
    d, k = pattern.dim, 10 ** rng.uniform(-1, 1, 2)
    counts = tuple(int(n) for n in rng.integers(1, 13 - 3 * d, d))
    box = Box(tuple(0.37 * n for n in counts))
    law = Isotropic(1.0, 1 / 3 if d == 2 else 1 / 4, "plane_stress" if d == 2 else "solid")
    lattice = fill(pattern, box, counts)
    solid = homogenise(pattern, k).tensor
    expected = {"shared": solid[0, 1] / (solid[0, 0] + (d - 2) * solid[0, 1])}
    if d == 2:
        expected["per_cell"] = k[1] / (2 * k[0] + k[1])
    for weights, ratio in expected.items():
        network = lattice_network(pulled(box, law, 1e-9 * k[0]), lattice, k, weights=weights)
        along, across = stretches(network, box)
        assert -across / along == pytest.approx(ratio, rel=1e-6)


@draws
def test_a_honeycomb_is_isotropic_with_a_ratio_from_a_third_to_one(rng):
    solid = homogenise(patterns.honeycomb(), 10 ** rng.uniform(-3, 3, 2)).tensor
    assert 1 / 3 <= isotropic_moduli(solid).nu <= 1
    assert 2 * solid[2, 2] == pytest.approx(solid[0, 0] - solid[0, 1], rel=1e-9)


@draws
def test_springs_of_no_rest_length_are_elements_on_irregular_meshes(rng):
    dim, counts = int(rng.choice([2, 3])), rng.integers(2, 5, 3)
    box = Box((1.0,) * dim)
    flat = box_discretisation(box, tuple(int(n) for n in counts[:dim]), "P1" if dim == 2 else "T1")
    inside = ((flat.points > 1e-9) & (flat.points < 1 - 1e-9)).all(axis=1)
    moved = flat.points + inside[:, None] * rng.uniform(-0.05, 0.05, flat.points.shape)
    body = Mesh(0.37 * moved, flat.cells, "triangle" if dim == 2 else "tetra")
    state = "solid" if dim == 3 else str(rng.choice(["plane_stress", "plane_strain"]))
    law = Isotropic(1e6, float(rng.uniform(0.0, 0.45)), state)
    root, tip = (Region((x, *[None] * (dim - 1))) for x in body.span[0])
    pull = Traction(tip, tuple(rng.uniform(-1e3, 1e3, dim)))
    problem = Problem(body, law, (Support(root, (0.0,) * dim),), (pull,))
    case = Case(problem, lattice="mesh edges", route="neo-Hookean")
    springs = solve_springs(case, spacing_of(case)).at(body.points)
    elements = solve_problem(problem, mesh_discretisation(body)).at(body.points)
    assert np.abs(springs - elements).max() <= 1e-9 * np.abs(elements).max()


@draws
def test_explicit_euler_grows_and_average_acceleration_is_stable(rng):
    omega, h = 10 ** rng.uniform(-3, 3), 10 ** rng.uniform(-6, 3)
    growth = {
        name: float(np.abs(np.linalg.eigvals(one_step_matrix(INTEGRATORS[name], omega, h))).max())
        for name in ("explicit_euler", "average_acceleration")
    }
    assert growth["explicit_euler"] >= np.sqrt(1 + (h * omega) ** 2) * (1 - 1e-12)
    assert growth["average_acceleration"] <= 1 + 1e-9
