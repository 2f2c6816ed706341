"""Stretch: at which homogeneous strain does a law of springs leave a band about a material?

Question   Stress of lattices of linear springs, pulled, pressed and sheared, beside neo-Hookean and
           St. Venant-Kirchhoff bodies of the same moduli, and beside linear elasticity.
Candidate  Equilibrium of a block of square-8 cells, pulled with free sides.
Reference  The lattice under a homogeneous strain, in closed form; laws of the materials.
Expected   Equal at small strain. Linear springs are not nearer to neo-Hookean than linear
           elasticity is farther from it in equibiaxial strain, where all isotropic lattices are
           linear elasticity; Green's springs are St. Venant-Kirchhoff at these strains, and springs
           of no rest length beside cells under pressure neo-Hookean.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import square
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.laws.green import GREEN
from msvalidate.springs.network.laws.zero_length import ZERO_LENGTH

from . import fibres

STRETCHES = (0.8, 0.9, 1.05, 1.1, 1.2, 1.35, 1.5)
CELLS, SIZE, THICKNESS = 4, 0.37, 0.2
"""Of the block along an edge; m, m."""
LOADS = {"uniaxial": 0.6, "pressed": -0.4, "equibiaxial": 0.6, "shear": 0.6}
"""Loading -> strain up to which a band is looked for."""
BANDS = (0.01, 0.05, 0.10)
TARGETS = {"neo-Hookean": fibres.neo_hookean, "St. Venant-Kirchhoff": fibres.st_venant}
NEVER = "never"
KNOWN = {
    ("square", "uniaxial"): (0.009, 0.045, 0.090), ("square", "pressed"): (0.009, 0.045, 0.090),
    ("square", "equibiaxial"): (0.010, 0.050, 0.102), ("square", "shear"): (0.127, 0.296, 0.440),
    ("triangular, row", "uniaxial"): (0.013, 0.066, 0.135),
    ("triangular, row", "pressed"): (0.013, 0.063, 0.123),
    ("triangular, across", "uniaxial"): (0.007, 0.035, 0.071),
    ("triangular, across", "pressed"): (0.007, 0.034, 0.068),
    ("triangular, across", "shear"): (0.090, 0.206, 0.297),
    ("random", "uniaxial"): (0.009, 0.045, 0.092), ("random", "pressed"): (0.009, 0.045, 0.089),
    ("random", "shear"): (0.146, 0.330, 0.473),
}  # fmt: skip
"""Strains by an independent program, against neo-Hookean, for each of `BANDS`."""
paths = partial(kit.Rule, unit="1", table="stretch")
RULES = (
    paths(
        "block of square-8 cells against the closed form, stress relative", 1e-9, layer="agreement",
        value=kit.Quotient("P_network", "P_springs"), reference=1.0, rows={"lattice": "square"},
        because="springs shared between cells make uniform strain exact; Newton's method and its "
        "refinement leave rounding, 1e-16 times a condition number of up to 1e5",
    ),
    paths(
        "block of square-8 cells against the closed form: stretch across", 1e-9, layer="agreement",
        value=kit.Difference("m_network", "m_springs"), rows={"lattice": "square"},
        because="as for the stress",
    ),
    paths(
        "triangles along a row: stress of linear elasticity", 1e-12, value="P_springs",
        reference="P_linear", rows={"lattice": "triangular, row"},
        because="the springs along the row carry all beyond the linear part: an identity",
    ),
    kit.Rule(
        "equibiaxial: every isotropic lattice is linear elasticity", 1e-12, "1",
        "all springs stretch alike, and the mean of n⊗n is half the unit tensor: an identity",
        table="identities", value="linear",
    ),
    kit.Rule(
        "Green's springs are St. Venant-Kirchhoff, any strain", 1e-12, "1",
        "fourth moments of the directions are isotropic: an identity", table="identities",
        value="green",
    ),
    kit.Rule(
        "springs of no rest length beside cells are neo-Hookean, any strain", 1e-12, "1",
        "second moments of the directions are isotropic: an identity", table="identities",
        value="zero_length",
    ),
    kit.Rule(
        "ellipticity lost under equibiaxial compression", 1e-9, "1",
        "(1/λ)/8 + (1 - 1/λ)/2 = 0 at λ = 3/4 in every isotropic lattice of the plane: left is "
        "the search's own 1e-12", table="limits", rows={"loading": "equibiaxial"},
        value="compression", reference=0.25,
    ),
    kit.Rule(
        "strains at which bands are left: an independent program", 1.1e-3, "1",
        "one unit of its last digit, cut off or rounded", table="bands",
        rows={"target": "neo-Hookean", "model": tuple({model for model, _ in KNOWN})},
        value=lambda rows: [abs(strain - known) for strain, known in _known(rows)],
    ),
    kit.Rule(
        "linear elasticity against linear springs, by strain at which 5 % of neo-Hookean is left",
        1e-9, "1", "in equibiaxial strain they are one, elsewhere springs leave earlier or at the "
        "same strain: the largest lead of springs is 0", table="bands",
        rows={"target": "neo-Hookean", "band": 0.05}, value=lambda rows: max(0.0, _lead(rows)),
    ),
)  # fmt: skip


def _known(rows: pd.DataFrame) -> list[tuple[float, float]]:
    return [
        (float(strain), KNOWN[model, loading][BANDS.index(band)])
        for model, loading, band, strain in rows[["model", "loading", "band", "strain"]].to_numpy()
        if (model, loading) in KNOWN
    ]


def _lead(rows: pd.DataFrame) -> float:
    """Largest strain by which the lattices alike in all directions outlast linear elasticity."""
    reach = pd.to_numeric(rows["strain"], errors="coerce").fillna(np.inf)
    at = rows.assign(reach=reach).pivot(index="loading", columns="model", values="reach")
    return float((at["random"] - at["linear elasticity"]).max())


def _change_rest(problem: kit.Problem, network: Network, answer: kit.Answer) -> kit.Array:
    """Rest lengths of diagonals 0.1 % off."""
    longer = np.where(network.distance > network.distance.min() * 1.1, 1.001, 1.0)
    other = replace(network, rest_length=network.rest_length * longer)
    return kit.solve_springs(problem, other, answer)


def _change_law(problem: kit.Problem, network: Network, answer: kit.Answer) -> kit.Array:
    return kit.solve_springs(problem, replace(network, law=GREEN), answer)


FAULTS: dict[str, dict[str, object]] = {
    "rest lengths of diagonals 0.1 % off": {
        "candidate": _change_rest, "questions": ("stretch",)
    },
    "Green's springs for linear ones": {"candidate": _change_law, "questions": ("stretch",)},
}  # fmt: skip
FIGURES = {
    "stretch": kit.series(
        "stretch", title="Stress of linear springs pulled with free sides", x="stretch",
        y="P_springs", by="lattice", size=(6.4, 4.0), beside={"P_neo_hookean": "neo-Hookean",
        "P_st_venant": "St. Venant-Kirchhoff"},
        labels=("stretch (1)", "nominal stress (N/m)"),
    ),
    "bands": kit.series(
        "bands", title="Strain at which 1, 5 and 10 % are left", x="band", y="strain", by="model",
        panel=("target", "loading"), across=4, log="xy", labels=("band (1)", "strain (1)"),
    ),
}  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Paths, identities, bands and limits; they are closed forms but for the candidate's block."""
    tables = {
        "stretch": pd.DataFrame(_paths(partial(pull_block, candidate))),
        "identities": pd.DataFrame(_identities(5 if setting.quick else 50)),
        "bands": pd.DataFrame(_bands()),
        "limits": pd.DataFrame(_limits()),
    }
    bands = tables["bands"].query("loading == 'uniaxial' and band == 0.05")
    left = bands.set_index(["target", "model"])["strain"]
    pulled = (
        "Pulled with free sides, linear springs on square-8 cells are 5 % off a neo-Hookean body "
        f"at {100 * left['neo-Hookean', 'square']:.1f} % strain, off Saint Venant-Kirchhoff's at "
        f"{100 * left['St. Venant-Kirchhoff', 'square']:.1f} %; linear elasticity at "
        f"{100 * left['neo-Hookean', 'linear elasticity']:.1f} and "
        f"{100 * left['St. Venant-Kirchhoff', 'linear elasticity']:.1f} %. The material's law "
        "decides who is nearer, not the strain."
    )
    pressed = (
        "Under compression linear springs lose their stability as a material: at "
        f"{100 * tables['limits']['compression'].min():.0f} to "
        f"{100 * tables['limits']['compression'].max():.0f} % by lattice and loading, at 25 % of "
        "equibiaxial compression in all."
    )
    return kit.Evidence(
        tables,
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(pulled, pressed),
        figures=FIGURES,
    )


Pull = Callable[[float], tuple[float, float]]


def _paths(block: Pull) -> list[dict[str, object]]:
    """Stress (N/m) and stretch across, with free sides."""
    rows = []
    for springs in fibres.lattices():
        for stretch in STRETCHES:
            P, m = fibres.pulled(springs.stress, "uniaxial", stretch - 1)
            row = {"lattice": springs.name, "stretch": stretch, "P_springs": P, "m_springs": m}
            own = block(stretch) if springs.name == "square" else (P, m)
            row |= dict(zip(("P_network", "m_network"), own, strict=True))
            for name, law in (
                ("neo_hookean", fibres.neo_hookean),
                ("st_venant", fibres.st_venant),
                ("linear", fibres.linear),
            ):
                row[f"P_{name}"] = fibres.pulled(law, "uniaxial", stretch - 1)[0]
            rows.append(row)
    return rows


def pull_block(candidate: kit.DisplacementSolver, stretch: float) -> tuple[float, float]:
    """Nominal stress (N/m, of λ = μ = 1 N/m) and stretch across of a block with free sides."""
    box = kit.Box((SIZE, SIZE))
    material = kit.Isotropic(fibres.E2 / THICKNESS, fibres.NU2, thickness=THICKNESS)
    held = (
        kit.Support(box.side("left"), (0.0, None)),
        kit.Support(box.side("bottom"), (None, 0.0)),
        kit.Support(box.side("right"), ((stretch - 1) * SIZE, None)),
    )
    problem = kit.Problem(box, material, held)
    network = lattice_network(problem, square(box, CELLS))
    u = candidate(problem, network, "nonlinear")
    right = network.points[:, 0] > SIZE * (1 - 1e-9)
    force = -Configuration(network, u).force()[right, 0].sum()
    top = network.points[:, 1] > SIZE * (1 - 1e-9)
    return float(force / SIZE), float(1 + u[top, 1].mean() / SIZE)


def _identities(count: int) -> list[dict[str, object]]:
    """Largest difference of stresses over the largest stress, of random strains."""
    rng, rows = np.random.default_rng(0), []
    for number in range(count):
        F = np.eye(2) + rng.uniform(-0.4, 0.4, (2, 2))
        G = np.linalg.inv(F).T
        cells = fibres.LAM * np.log(np.linalg.det(F)) * G - fibres.MU * G
        equal = np.eye(2) * rng.uniform(0.7, 1.7)
        for at, springs in enumerate(fibres.lattices()):
            green, pulling = (fibres.lattices(law)[at] for law in (GREEN, ZERO_LENGTH))
            wanted = fibres.st_venant(F), fibres.neo_hookean(F), fibres.linear(equal)
            ours = green.stress(F), pulling.stress(F) / 4 + cells, springs.stress(equal)
            off = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(ours, wanted, strict=True)]
            names = ("green", "zero_length", "linear")
            rows.append(
                {"lattice": springs.name, "case": number} | dict(zip(names, off, strict=True))
            )
    return rows


def _bands() -> list[dict[str, object]]:
    """Strains at which bands about the materials are left."""
    models = {springs.name: springs.stress for springs in fibres.lattices()}
    models |= {"linear elasticity": fibres.linear}
    rows = []
    for target, law in TARGETS.items():
        for (loading, most), (model, stress) in (
            (a, b) for a in LOADS.items() for b in models.items()
        ):
            for band in BANDS:
                how = "uniaxial" if loading == "pressed" else loading
                strain = fibres.first_outside(stress, law, how, band, most)
                row = {"target": target, "loading": loading, "model": model, "band": band}
                rows.append(row | {"strain": strain if np.isfinite(strain) else NEVER})
    return rows


def _limits() -> list[dict[str, object]]:
    """Compression at which ellipticity is lost."""
    return [
        {"lattice": each.name, "loading": how, "compression": fibres.ellipticity_lost(each, how)}
        for each in fibres.lattices()[:3]
        for how in ("uniaxial", "confined", "equibiaxial")
    ]
