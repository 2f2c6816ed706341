"""Along which way does a crack run in a pulled strip?

Question   Direction of a crack in lattices turned by an angle, and in random ones.
Candidate  Springs that break at one critical stretch, the most stretched first.
Reference  Elasticity: the strip is symmetric about the crack, which goes straight on, at 0.
Expected   Along a row of the lattice if the lattice is turned by an angle within one of the ranges
           of `ALONG`. In the ranges of `OFF` most cracks step between rows or scatter. Turns and
           places are drawn at random. Random lattices have no rows: their breaks make a cloud,
           whose mean over seeds is about 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.problem import Array, Box
from msvalidate.springs.bodies.toughness import crossings
from msvalidate.springs.lattice.turned import fill_rotated
from msvalidate.springs.lattice.voronoi import voronoi_box

from .springs import LATTICES, Grow, middles, pulled

SIZE, LENGTH = (50.0, 31.0), 22.0
"""Of the strip, and of its crack."""
AHEAD, BEFORE = 2.0, 6.0
"""Of the tip, and of clamps and end, between which a path is looked at."""
MOST_BREAKS = {"square-8": 80, "triangular": 56, "Voronoi": 120}
"""At a spacing of 1: some three and two a spacing, fewer than part the body."""
ON_ROW, ONE_LINE = 3.0, 0.5
"""Angle (°) from a row, and width (spacings), up to which a crack follows the row."""


@dataclass(frozen=True)
class Turns:
    """Range of turns (°) of a lattice, to either side, and the rows that a crack can follow.

    Rows lie at the turn and `row` more, and at every `period` from there; `along` names them.
    """

    lattice: str
    low: float
    high: float
    row: float
    period: float
    along: str = ""

    def off_row(self, direction: float, turn: float) -> float:
        """Angle (°) of a direction from the nearest of the rows."""
        return (direction - turn - self.row + self.period / 2) % self.period - self.period / 2

    def __str__(self) -> str:
        by = f"{self.low:g} to {self.high:g}°" if self.high > self.low else f"{self.low:g}°"
        return f"{self.lattice} turned by {by}"


ALONG = (
    Turns("square-8", 0.0, 0.0, 0.0, 90.0, "an axis"),
    Turns("square-8", 10.0, 24.0, 0.0, 90.0, "an axis"),
    Turns("square-8", 28.0, 36.0, 45.0, 90.0, "a diagonal"),
    Turns("triangular", 27.0, 33.0, 0.0, 60.0, "a row to either side"),
)
"""Turns at which a crack follows a row."""
OFF = (
    Turns("square-8", 4.0, 8.0, 0.0, 45.0),
    Turns("square-8", 41.0, 43.0, 0.0, 45.0),
    Turns("triangular", 5.0, 20.0, 0.0, 60.0),
)
"""Turns at which most cracks do not."""
RANDOM = Turns("Voronoi", 0.0, 0.0, 0.0, np.inf)
Case = tuple[Turns, float, float, float, int]
"""Range, turn, height of the crack over the middle, spacing and seed."""
RULES = (
    kit.Rule(
        "turned lattices: direction of cracks from the row of their range", ON_ROW, "°",
        "a crack between two rows steps from one to the next where it meets the end", table="paths",
        rows={"lattice": tuple(LATTICES)}, value="off_row",
    ),
    kit.Rule(
        "turned lattices: distance of breaks from a line, root of the mean square", ONE_LINE, "1",
        "a crack between two rows", table="paths", rows={"lattice": tuple(LATTICES)}, value="width",
    ),
    kit.Rule(
        "turns outside the ranges: part of the cracks that follow a row", 0.5, "1",
        "other breaks relieve no row: most cracks step or scatter", table="off_rows",
        value=lambda t: [float(follows(t).mean())],
    ),
    kit.Rule(
        "random lattices: distance of breaks from a line, or 2 spacings if that is less", 1e-9, "1",
        "springs break at random places first: no one crack", table="paths",
        rows={"lattice": "Voronoi"}, value=lambda t: np.minimum(t["width"], 2.0), reference=2.0,
    ),
)  # fmt: skip
ENDS = ("x", "y", "x_end", "y_end")


def draw_cases(setting: kit.Setting, ranges: tuple[Turns, ...]) -> list[Case]:
    """Draw turns and heights at random; in full mode rows are also tried at half the spacing."""
    rng = np.random.default_rng(setting.seed)
    drawn = {1.0: 3} if setting.quick else {1.0: 12, 0.5: 4 if ranges is ALONG else 0}
    return [
        (each, float(rng.choice((-1, 1)) * rng.uniform(each.low, each.high)),
         float(rng.uniform(-1, 1)), spacing, 0)
        for each, spacing in product(ranges, drawn)
        for _ in range(drawn[spacing])
    ]  # fmt: skip


def follows(table: pd.DataFrame) -> pd.Series:
    """Mask of the cracks that run along one row."""
    return (table["off_row"].abs() <= ON_ROW) & (table["width"] <= ONE_LINE)


def path_of(grow: Grow, case: Case) -> tuple[dict[str, object], Array]:
    """Direction of the path, and ends (b, 2, 2) in m from the tip of the springs that broke."""
    turns, turn, height, spacing, seed = case
    name = turns.lattice
    if name == "Voronoi":
        network = pulled(voronoi_box(Box(SIZE), spacing, seed=seed), (1.0,))
    else:
        pattern, k = LATTICES[name]
        network = pulled(fill_rotated(pattern, Box(SIZE), spacing, np.radians(turn)), k)
    at, middle = crossings(network.points, network.springs, SIZE[1] / 2 + height), middles(network)
    clamped = np.abs(middle[:, 1] - SIZE[1] / 2) > SIZE[1] / 2 - 2
    found = grow(
        network, np.where(clamped, np.inf, 0.01), 1e3, crack=np.flatnonzero(at <= LENGTH),
        most_breaks=round(MOST_BREAKS[name] / spacing),
    )  # fmt: skip
    x = middle[found.broken] - [LENGTH, SIZE[1] / 2 + height]
    on = (x[:, 0] > AHEAD) & (x[:, 0] < SIZE[0] - LENGTH - BEFORE)
    on &= np.abs(x[:, 1]) < SIZE[1] / 2 - BEFORE
    x, ends = x[on], network.points[network.springs[found.broken[on]]]
    # A cloud has no axis: of random lattices the line through the tip, else that of the breaks.
    way = x.T @ x[:, 0] if name == "Voronoi" else np.linalg.svd(x - x.mean(axis=0))[2][0]
    way = way / np.linalg.norm(way)
    apart = (x - (0 if name == "Voronoi" else x.mean(axis=0))) @ [-way[1], way[0]]
    angle = (float(np.degrees(np.arctan2(way[1], way[0]))) + 90) % 180 - 90
    return {
        "lattice": name, "turn": turn, "height": height, "spacing": spacing, "seed": seed,
        "direction": angle,
        "off_row": turns.off_row(angle, turn) if name in LATTICES else 0.0,
        "width": float(np.sqrt((apart**2).mean())) / spacing,
    }, ends - [LENGTH, SIZE[1] / 2 + height]  # fmt: skip


def run(grow: Grow, setting: kit.Setting) -> kit.Evidence:
    """Paths by lattice, turn, place, spacing and seed."""
    on, off = draw_cases(setting, ALONG), draw_cases(setting, OFF)
    seeds = range(3) if setting.quick else range(8)
    sizes = (1.0,) if setting.quick else (1.0, 0.5)
    cloud: list[Case] = [
        (RANDOM, 0.0, 0.0, size, setting.seed + k) for size in sizes for k in seeds
    ]
    cases = [*on, *cloud, *off]
    found = setting.sweep(partial(path_of, grow), cases, "paths")
    table = pd.DataFrame([row for row, _ in found])
    paths, off_rows = table.iloc[: -len(off)], table.iloc[-len(off) :].reset_index(drop=True)
    breaks: dict[Turns, pd.DataFrame] = {}  # of the first crack of each range
    for (turns, turn, *_), (_, ends) in zip(cases, found, strict=True):
        own = pd.DataFrame(ends.reshape(-1, 4), columns=list(ENDS))
        breaks.setdefault(turns, own.assign(lattice=title(turns.lattice, turn)))
    return kit.Evidence(
        {"paths": paths, "breaks": pd.concat(breaks.values(), ignore_index=True),
         "off_rows": off_rows},
        tolerances=RULES, columns=kit.columns(__file__), findings=(finding(paths, off_rows),),
        figures={"paths": draw_paths},
    )  # fmt: skip


def finding(paths: pd.DataFrame, off_rows: pd.DataFrame) -> str:
    """Number of cracks that follow a row, and the cloud of random lattices."""
    turned, random = (paths[(paths["lattice"] == "Voronoi") == own] for own in (False, True))
    rows = "; ".join(f"{each}, along {each.along}" for each in ALONG)
    spread = ", ".join(
        f"{own['direction'].mean():.0f} ± {own['direction'].std():.0f}° at a spacing of {size:g} "
        f"({own['width'].mean() * float(str(size)):.1f} wide)"
        for size, own in random.groupby("spacing", sort=False)
    )
    return (
        "Elasticity lets a crack in a pulled strip go straight on, at 0°. In turned lattices a "
        f"crack can follow a row ({rows}): {len(turned)} cracks at random turns and places were "
        f"within {turned['off_row'].abs().max():.1f}° of it. Of {len(off_rows)} cracks at other "
        f"turns ({'; '.join(map(str, OFF))}), {follows(off_rows).sum()} followed a row, and the "
        "others stepped from row to row or scattered. Random lattices break in a cloud in place of "
        f"a crack: {spread}, over {random['seed'].nunique()} seeds."
    )


def title(name: str, turn: float) -> str:
    """Heading of a panel."""
    return name if name == "Voronoi" else f"{name} at {turn:.3g}°"


def draw_paths(tables: kit.Tables) -> Figure:
    """Springs that broke, ahead of a crack that elasticity lets go straight on."""
    groups = list(tables["breaks"].groupby("lattice", sort=False))
    rows = -(-len(groups) // 3)
    figure, axes = kit.figures.new_figure(3, rows, size=(2.45, 2.45))
    for axis, (name, own) in zip(axes, groups, strict=False):
        ends = own[list(ENDS)].to_numpy().reshape(-1, 2, 2)
        axis.add_collection(LineCollection(list(ends), colors=kit.figures.COLOURS[1]))
        axis.set(xlim=(0, 23), ylim=(-10.5, 10.5), title=name, aspect="equal")
        axis.set(xlabel="ahead of the tip (spacings)", ylabel="above it (spacings)")
    for axis in axes[len(groups) :]:
        axis.remove()
    figure.suptitle(str(draw_paths.__doc__).rstrip("."))
    return figure
