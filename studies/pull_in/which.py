"""Which pull-in is which: what does the word mean, and which number belongs to it?

Question   Several instabilities of soft dielectrics go by one name, and their thresholds by one
           unit, √(μ/ε). Which of them can springs or elements show, and what is each worth?
Candidate  Thresholds computed from the laws that they are of (`way.Laws`).
Reference  Closed forms (`dielectric.actuator.uniform`). Of creases there is the literature alone:
           neither springs nor smooth elements fold by themselves, and nothing is asked of them.
Expected   Stress linear in the thickness, area held: l = 2/3, V² = 8Ch²/27ε, the third of the gap
           of electrostatic actuators. The lattice, area held: l = 0.692. A free neo-Hookean sheet:
           stretch 2^(1/3), thickness 0.630, nominal field 0.687, true field 1.091 √(μ/ε)
           [ZhaoSuo2007]. In plane strain the nominal field (1 - λ⁻⁴)^½ rises for ever: no pull-in.
           A bonded film that keeps its volume: √2 as waves shorten. Creases come before these
           waves: linear stability overestimates the field [WangZhangZhao2011, WangTahir2011].
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform

from . import homogeneous, pressed, slab
from .way import Laws, PullInSolver
from .which_drawing import draw

QUICK_WAVES, WAVES = (0.5, 2.0, 8.0), (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""κ = kh of the waves of a bonded film that elements are asked about."""
STRETCHES = (1.2, 1.5, 2.0, 4.0, 16.0)
"""Of the sheet in plane strain."""
RULES = (
    kit.Rule(
        "field of a sheet in plane strain over its closed form, from 1", 1e-6, "1",
        "central differences of 1e-5 leave 1e-10 of the second derivative and as much of rounding, "
        "over a slope of 1e-2 or more",
        table="sheet_in_plane_strain", value=kit.Quotient("field_found", "field_theory"),
        reference=1.0,
    ),
    kit.Rule(
        "field of a wave on a bonded film, by elements over its closed form, from 1", 2e-4, "1",
        "energies of elements of the second degree with 12 to half a wave: (π/12)⁴/12 = 4e-4 at "
        "most, halved by the root",
        table="waves_of_a_film", value=kit.Quotient("field_found", "field_theory"), reference=1.0,
    ),
)  # fmt: skip
ZHAO_SUO = "Zhao and Suo 2007, doi:10.1063/1.2768641"
WANG = "Wang, Zhang and Zhao 2011, doi:10.1103/PhysRevLett.106.118301"
TAHIR = "Wang, Tahir, Zhang and Zhao 2011, doi:10.1039/c1sm05645j"
Three = Sequence[object]


def run(candidate: PullInSolver, setting: kit.Setting) -> kit.Evidence:
    """Compute what can be, beside the closed forms."""
    laws = candidate.laws
    plane = pd.DataFrame(
        {
            "stretch": stretch,
            "field_theory": uniform.plane_strain_nominal_field(stretch),
            "field_found": homogeneous.plane_field(stretch, laws.sheet),
        }
        for stretch in STRETCHES
    )
    waves = pd.DataFrame(
        {
            "kh": kappa,
            "wavelength_over_h": 2 * np.pi / kappa,
            "field_theory": uniform.bonded_film_field(kappa),
            "field_found": laws.wave(kappa),
        }
        for kappa in (QUICK_WAVES if setting.quick else WAVES)
    )
    table = pd.DataFrame([*thin_films(laws), *sheets(laws), *bonded(waves.iloc[-1])])
    sharp = table[table["computed_by"].str.contains("springs|elements with|minimised")]
    ratios = [
        float(row[f"{name}_found"]) / float(row[f"{name}_theory"])
        for row in sharp.to_dict("records")
        for name in ("thickness", "nominal", "true")
        if isinstance(row[f"{name}_theory"], float) and isinstance(row[f"{name}_found"], float)
    ]
    own = (
        kit.Tolerance(
            "pull-in by another route over its closed form: thickness and field, from 1", 1e-4, "1",
            "a field is flat at its largest, so its place is known to the root of the field's own "
            "error: 1e-5 where derivatives are differences (1e-10), less where they are solved for",
            observed=kit.farthest_value(ratios, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"which": table, "sheet_in_plane_strain": plane, "waves_of_a_film": waves},
        tolerances=(*RULES, *own),
        figures={"which": draw},
        columns=kit.columns(__file__),
        findings=findings(table, waves),
        # Where a field is largest, and what differences leave of its slope there.
    )


def row(
    names: tuple[str, ...], theory: Three, found: Three, words: tuple[str, ...]
) -> dict[str, object]:
    """A row: instability, hold and unit; thickness, nominal and true field twice; three remarks."""
    cells: dict[str, object] = dict(zip(("pull_in", "held", "unit"), names, strict=True))
    for name, known, computed in zip(("thickness", "nominal", "true"), theory, found, strict=True):
        cells |= {f"{name}_theory": known, f"{name}_found": computed}
    return cells | dict(zip(("computed_by", "source", "to_take"), words, strict=True))


def fields(thickness: float, voltage: float, unit: float) -> tuple[float, float, float]:
    """Thickness, nominal and true field over a unit (V/m), of the slab."""
    nominal = voltage / slab.HEIGHT / unit
    return thickness, nominal, nominal / thickness


def thin_films(laws: Laws) -> list[dict[str, object]]:
    """Films whose area is held, pressed charge by charge."""
    modulus = float(np.sqrt(slab.AXIAL / slab.PERMITTIVITY))
    line = uniform.linear_stress_pull_in(slab.AXIAL, slab.HEIGHT, slab.PERMITTIVITY)
    lattice, maximum = ("√(μ/ε)", slab.NATURAL, slab.PULL_IN), "maximum of l²·P(l)"
    cases = (
        (
            "thinning, stress linear in the thickness", ("√(C/ε)", modulus, line), laws.straight,
            "springs, charge by charge", "maximum of l²·(1 - l)",
            "what electrostatic actuators quote, a third of the gap: it is no soft solid's",
        ),
        (
            "thinning, square lattice with diagonals", lattice, laws.lattice,
            "springs, charge by charge", maximum,
            "the network's own pull-in: compare runs with this one",
        ),
        (
            "thinning, elements with the lattice's energy", lattice, laws.elements,
            "elements with the lattice's law, charge by charge", maximum,
            "the same law, other code: the law decides, not the method",
        ),
    )  # fmt: skip
    rows = []
    for name, (unit, size, exact), law, *words in cases:
        found = pressed.pull_in(law)
        theory = fields(exact.thickness, exact.voltage, size)
        computed = fields(found.thickness, found.voltage, size)
        rows.append(row((name, "area held", unit), theory, computed, tuple(words)))
    return rows


def sheets(laws: Laws) -> list[dict[str, object]]:
    """Neo-Hookean sheets that widen as they are thinned."""
    exact = uniform.biaxial_pull_in(1.0, 1.0)
    most = homogeneous.plane_field(STRETCHES[-1], laws.sheet)
    return [
        row(
            ("thinning, neo-Hookean sheet", "free to widen along both axes", "√(μ/ε)"),
            (exact.thickness, exact.voltage, exact.voltage / exact.thickness),
            homogeneous.free_pull_in(laws.sheet),
            (
                "energy minimised over shapes", ZHAO_SUO,
                "the textbooks' pull-in: of a film free in space, not of a bonded or a plane one",
            ),
        ),
        row(
            ("thinning, neo-Hookean sheet", "free to widen along one axis", "√(μ/ε)"),
            ("none", 1.0, "endless"), ("none", most, "endless"),
            (
                f"energy minimised, at a stretch of {STRETCHES[-1]:g}",
                "(1 - λ⁻⁴)^½, which rises for ever",
                "a plane model of a free film has no pull-in, only a voltage that it nears",
            ),
        ),
    ]  # fmt: skip


def bonded(shortest: pd.Series) -> list[dict[str, object]]:
    """Waves of a bonded film that keeps its volume; creases, which nothing here folds by itself."""
    short, limit = float(shortest["field_found"]), uniform.bonded_film_limit()
    theory, seen = uniform.CREASING_FIELD_THEORY, uniform.CREASING_FIELD_EXPERIMENT
    not_computed = ("not computed",) * 3
    apart = (
        f"creases stand {uniform.CREASING_WAVELENGTH:g} heights apart: no wave of the table does"
    )
    return [
        row(
            ("waves of the surface", "bonded, volume kept, linear", "√(μ/ε)"),
            ("as it was", limit, limit), ("as it was", short, short),
            (
                f"stiffness of finite elements, kh = {shortest['kh']:g}",
                "surface stiffness 2μk against εE²k",
                "the shortest wave first: without surface energy the mesh chooses the wavelength",
            ),
        ),
        row(
            ("creases, theory", "bonded, neo-Hookean", "√(μ/ε)"),
            ("as it was", theory, theory), not_computed,
            (
                "literature alone", TAHIR,
                "a network that stays flat up to a higher field does not prove that a film would",
            ),
        ),
        row(
            ("creases, experiment", "bonded, elastomers", "√(μ/ε)"),
            ("as it was", seen, seen), not_computed,
            ("literature alone", WANG, apart),
        ),
    ]  # fmt: skip


def findings(table: pd.DataFrame, waves: pd.DataFrame) -> tuple[str, ...]:
    """What the word pull-in covers."""
    net = table[table["pull_in"].str.contains("square lattice")].iloc[0]
    free = table[table["held"] == "free to widen along both axes"].iloc[0]
    first, last = waves.iloc[0], waves.iloc[-1]
    many = (
        f"One word, fields from {float(free['nominal_found']):.3g} to {first['field_found']:.3g} "
        "√(μ/ε) that are no versions of each other: the lattice with its area held is pulled in at "
        f"a nominal {float(net['nominal_found']):.4g} and a true {float(net['true_found']):.4g}, "
        f"thickness {float(net['thickness_found']):.4g}; a free neo-Hookean sheet at "
        f"{float(free['nominal_found']):.4g} and {float(free['true_found']):.4g}, thickness "
        f"{float(free['thickness_found']):.4g}."
    )
    short = (
        f"Waves of a bonded film need a field that falls from {first['field_found']:.3g} at kh = "
        f"{first['kh']:g} to {last['field_found']:.4g} at {last['kh']:g}: the shortest grow first."
    )
    return many, short
