"""Shortcuts: what becomes of forces that are not the derivative of the energy?

Question   How wrong are three ways to take forces from right charges: σ²/(2ε) a face, Coulomb's law
           between middles of segments, and half of a segment's force to each of its ends?
Candidate  Charges of facing strips, and their consistent forces.
Reference  Closed forms. Of charges that grow like K/√s towards an edge, of both faces together, the
           tip is pulled with πK²/(4ε), so K² follows from dW/dw of the strips.
Expected   σ²/(2ε) of all charge counts what the faces hold on either side as if it were on one, and
           grows by K²·ln 2/ε with every doubling of even segments, for ∫σ² has no limit. A row of
           line charges a length l apart, seen from straight above at a gap d, pulls coth(πd/l)
           times as much as the even sheet. Halves by the field of a segment's middle leave out what
           a segment does to itself and that its field is not even: the edge's own point feels half
           of what it should. On graded segments, whose neighbours are of other lengths, they are
           wrong in total however many there are.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges import Charges, facing_strips

from .common import VOLTAGES, ChargeSolver
from .derivatives import growth

RATIO = 6.0
"""Width over gap of the strips."""
DOUBLINGS = {"uniform": 1, "cosine": 2}
"""Grading -> how often the last segment halves when their number doubles."""
SEGMENTS = (30, 60, 120, 240, 480)
QUICK_SEGMENTS = (30, 60, 120, 240)
LENGTHS = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
"""Of segments over the gap, for point sums."""
ROW = 61
"""Segments of each strip for point sums; the middle one is looked at."""
NEAR = 4
"""Points from the edge whose forces are told."""
HALF = 0.5 * (VOLTAGES[0] - VOLTAGES[1]) ** 2
"""½V² (V²), with unit gap and permittivity."""
RULES = (
    kit.Rule(
        "growth of σ²/(2ε) with a doubling of segments, over K²·ln 2/ε a halving of the last",
        0.02, "1",
        "the tip looks the same at every fineness; what differs is the first-order error of K², "
        "a few times 1/n",
        table="both_faces_growth", value="growth_over_expected", reference=1.0,
    ),
    kit.Rule(
        "pull of point sums on the middle of wide strips, over coth(πd/l)", 2e-3, "1",
        "ends are 30 segments away, where points and segments differ by (1/30)²/24 or so, and the "
        "density by its margin of d/(30πl)·l/w",
        table="point_sums", value=kit.Quotient("points_over_exact", "coth"), reference=1.0,
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Measure the three."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(DOUBLINGS, numbers))
    faces = pd.DataFrame(setting.sweep(partial(both_faces, candidate), cases, "both faces"))
    growths = pd.DataFrame(
        [growth_with_refinement(grading, rows) for grading, rows in by_grading(faces)]
    )
    points = pd.DataFrame([point_sums(candidate, length) for length in LENGTHS])
    tips = pd.concat([tip(candidate, *case) for case in cases], ignore_index=True)
    own = (
        kit.Tolerance(
            "consistent force along half a strip, finest, over that on a tip by the closed form",
            2e-4, "1",
            "what even segments miss at the tip goes with their length over the gap, 0.025 and "
            "less, with a small factor: the tip's pull holds for the charge that is there",
            observed=kit.farthest_value(half_strips(tips, max(numbers))["along"], 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            "both_faces": faces,
            "point_sums": points,
            "both_faces_growth": growths,
            "halves": tips,
        },
        tolerances=(*RULES, *own),
        figures={"shortcuts": draw},
        columns=kit.columns(__file__),
        findings=findings(faces, points, tips),
    )


def by_grading(table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Rows of each grading."""
    return [(str(grading), rows) for grading, rows in table.groupby("grading", sort=False)]


def both_faces(candidate: ChargeSolver, case: tuple[str, int]) -> dict[str, object]:
    """Row of Σσ²·l/(2ε) of the upper strip."""
    grading, segments = case
    electrodes = facing_strips(RATIO, 1.0, segments, grading=grading)
    found = candidate.charges(electrodes)
    upper = electrodes.electrode == 0
    total = float((found.charge * found.density)[upper].sum()) / 2
    return {
        "grading": grading,
        "segments": segments,
        "faces_over_exact": total / (HALF * growth(RATIO) * RATIO),
    }


def growth_with_refinement(grading: str, rows: pd.DataFrame) -> dict[str, object]:
    """Row of the last doubling.

    The tip's force is dW/dw/2, for all four tips of the strips move by dw/2, so K²/ε is
    2/π·dW/dw; the sum grows by that times ln 2 with each halving, and the pull is w/d·dW/dw.
    """
    last = rows["faces_over_exact"].to_numpy()[-2:]
    expected = DOUBLINGS[grading] * 2 * np.log(2) / (np.pi * RATIO)
    return {
        "grading": grading,
        "segments": rows["segments"].iloc[-1],
        "growth_over_expected": float(last[1] - last[0]) / expected,
    }


def point_sums(candidate: ChargeSolver, length: float) -> dict[str, object]:
    """Row of one length of segments."""
    electrodes = facing_strips(ROW * length, 1.0, ROW, grading="uniform")
    found = candidate.charges(electrodes)
    at = electrodes.middle[ROW // 2]
    apart = at - electrodes.middle[electrodes.electrode == 1]
    charge = found.charge[electrodes.electrode == 1]
    pulled = float((charge * apart[:, 1] / (apart**2).sum(axis=1)).sum()) / (2 * np.pi)
    return {
        "length_over_gap": length,
        "points_over_exact": pulled / float(found.field(at[None])[0, 1]),
        "coth": float(1 / np.tanh(np.pi / length)),
    }


def halve_to_ends(found: Charges) -> kit.Array:
    """Force (n, 2) on points: half of what the field in its middle does to a segment, each end."""
    electrodes = found.moments.electrodes
    pulled = found.charge[:, None] * found.field(electrodes.middle)
    total = np.zeros_like(electrodes.points)
    for end in electrodes.segments.T:
        np.add.at(total, end, 0.5 * pulled)
    return total


def tip(candidate: ChargeSolver, grading: str, segments: int) -> pd.DataFrame:
    """Rows of the points next to an edge, and of all of half the strip."""
    electrodes = facing_strips(RATIO, 1.0, segments, grading=grading)
    found = candidate.charges(electrodes)
    columns: dict[str, object] = {
        "grading": grading,
        "segments": segments,
        "from_edge": [*range(NEAR), "half"],
    }
    for name, force in (("", candidate.forces(found)), ("_halves", halve_to_ends(found))):
        line = force[segments::-1][: segments // 2 + 1]
        whole = np.vstack([line[:NEAR], line[:-1].sum(axis=0) + 0.5 * line[-1]])
        columns[f"along{name}"] = whole[:, 0] / (0.5 * HALF * growth(RATIO))
        columns[f"across{name}"] = -whole[:, 1] / (HALF * growth(RATIO) * RATIO)
    return pd.DataFrame(columns)


def half_strips(tips: pd.DataFrame, segments: int) -> pd.DataFrame:
    """Rows of all of half a strip, by grading."""
    rows = tips[(tips["from_edge"] == "half") & (tips["segments"] == segments)]
    return rows.set_index("grading")


def findings(faces: pd.DataFrame, points: pd.DataFrame, tips: pd.DataFrame) -> tuple[str, ...]:
    """The three, in sentences."""
    ends = [
        f"{grading} {rows['faces_over_exact'].min():.2f} ... {rows['faces_over_exact'].max():.2f}"
        for grading, rows in by_grading(faces)
    ]
    numbers = faces["segments"]
    edge = tips[(tips["from_edge"] == 0) & (tips["grading"] == "uniform")].iloc[-1]
    whole = half_strips(tips, numbers.max())["along_halves"]
    coarse = points[points["length_over_gap"].isin((0.5, 1.0, 2.0))]
    wrong = ", ".join(
        f"{ratio - 1:.1%} at l = {length:g} d"
        for length, ratio in zip(
            coarse["length_over_gap"], coarse["points_over_exact"], strict=True
        )
    )
    faces_said = (
        f"σ²/(2ε) of all charge, over the pull on strips of w/d = {RATIO:g} with {numbers.min()} "
        f"to {numbers.max()} segments: {', '.join(ends)}; it has no limit."
    )
    halves_said = (
        f"On the edge's own point consistent forces put {edge['along']:.2f} of the tip's force, "
        f"halves {edge['along_halves']:.2f}. On half a strip halves put {whole['uniform']:.3f} of "
        f"it with even segments and {whole['cosine']:.3f} with graded ones."
    )
    return faces_said, f"Coulomb's law between middles pulls too hard: {wrong}.", halves_said


def draw(tables: kit.Tables) -> Figure:
    """Forces by three shortcuts over those of the closed form or the energy, a panel each."""
    faces, points, tips = tables["both_faces"], tables["point_sums"], tables["halves"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.5, 2.9))
    both, sums, tip_axis = kit.figures.widen_third(figure, axes)
    for place, (grading, rows) in enumerate(by_grading(faces)):
        style, n = kit.figures.series_style(place), rows["segments"].to_numpy()
        pull = rows["faces_over_exact"].to_numpy()
        both.semilogx(n, pull, ls="", label=f"{grading} segments", **style)
        slope = DOUBLINGS[grading] * 2 / (np.pi * RATIO)
        both.semilogx(n, pull[-1] + slope * np.log(n / n[-1]), color=style["color"], lw=0.8)
    kit.figures.tick_at(both, faces["segments"])
    both.set(title=f"pressure σ²/(2ε), w/d = {RATIO:g}", xlabel="segments of each strip (1)")
    both.set_ylabel("pull over the closed form's (1)")
    lengths, blue = points["length_over_gap"], kit.figures.COLOURS[0]
    sums.plot(lengths, points["points_over_exact"], "o", color=blue, label="point sums")
    drawn = np.linspace(min(LENGTHS), max(LENGTHS), 80)
    sums.plot(drawn, 1 / np.tanh(np.pi / drawn), color="black", lw=0.8, label="coth(πd/l)")
    sums.set(title="Coulomb's law between middles", xlabel="length of segments\nover gap, l/d (1)")
    sums.set_ylabel("pull over that of\neven segments (1)")
    near = tips[(tips["from_edge"] != "half") & (tips["grading"] == "uniform")]
    near = near[near["segments"] == near["segments"].max()]
    where = near["from_edge"].astype(float)
    for place, (column, name) in enumerate((("along", "consistent"), ("along_halves", "halves"))):
        colour, x = kit.figures.COLOURS[place], where + 0.4 * place - 0.2
        tip_axis.bar(x, near[column], 0.36, color=colour, label=name)
    tip_axis.set_xticks(list(range(NEAR)))
    tip_axis.set(title="force along the strip", xlabel="points from the edge (1)")
    tip_axis.set_ylabel("force over that on the tip (1)")
    for axis in (both, sums, tip_axis):
        axis.legend(fontsize=8)
    figure.suptitle("Three shortcuts for forces between facing strips")
    return figure
