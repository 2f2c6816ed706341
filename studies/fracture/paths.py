"""Along which way does a crack run in a pulled strip?

Question   Direction of a crack in lattices turned by an angle, and in random ones.
Candidate  Springs that break at one critical stretch, the most stretched first.
Reference  Elasticity: the strip is symmetric about the crack, which goes straight on, at 0.
Expected   Along a row of the lattice, at the turn or 60° from it, at any spacing. Random lattices
           have no rows: their breaks make a cloud, whose mean over seeds is about 0.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bodies.toughness import crossings
from msvalidate.lattice.turned import fill_rotated
from msvalidate.lattice.voronoi import voronoi_box
from msvalidate.problem import Array, Box

from .springs import LATTICES, Grow, middles, pulled

SIZE, LENGTH = (50.0, 31.0), 22.0
"""Of the strip, and of its crack."""
AHEAD, BEFORE = 2.0, 6.0
"""Of the tip, and of clamps and end, between which a path is looked at."""
HEIGHTS = (0.013, 0.31, -0.27, 0.62)
"""Of the crack over the middle: where it lies among the rows."""
NEW = (-0.44, 0.18)
"""The same, not looked at before the rules were written."""
TURNS = (("square-8", 0.0), ("square-8", 10.0), ("triangular", 30.0))
Case = tuple[str, float, float, float, int]
"""Lattice, turn, height, spacing and seed."""
ROWS = {"square-8": 45.0, "triangular": 60.0}
RULES = (
    kit.Rule(
        "direction of cracks in turned lattices from the nearest row", 3.0, "°",
        "a crack between two rows steps from one to the next where it meets the end", table="paths",
        rows={"lattice": tuple(ROWS)}, value="off_row",
    ),
    kit.Rule(
        "the same of places not tried before", 3.0, "°", "as before", table="paths",
        rows={"height": NEW}, value="off_row",
    ),
    kit.Rule(
        "square-8 turned by 10°: direction at half the spacing", 3.0, "°",
        "rows are rows at any spacing", table="paths", rows={"lattice": "square-8", "turn": 10.0,
        "spacing": 0.5}, value="direction", reference=10.0,
    ),
    kit.Rule(
        "turned lattices: distance of breaks from a line, root of the mean square", 0.5, "1",
        "a crack between two rows", table="paths", rows={"lattice": tuple(ROWS)}, value="width",
    ),
    kit.Rule(
        "random lattices: the same, or 2 spacings if that is less", 1e-9, "1",
        "springs break at random places first: no one crack", table="paths",
        rows={"lattice": "Voronoi"}, value=lambda t: np.minimum(t["width"], 2.0), reference=2.0,
    ),
)  # fmt: skip
ENDS = ("x", "y", "x_end", "y_end")
ZIGZAG = (("triangular", 10.0), ("triangular", 20.0))
"""Turns at which a crack follows no row: looked at, without a rule."""


def path_of(grow: Grow, case: Case) -> tuple[dict[str, object], Array]:
    """Direction of the path, and ends (b, 2, 2) in m from the tip of the springs that broke."""
    name, turn, height, spacing, seed = case
    if name == "Voronoi":
        network = pulled(voronoi_box(Box(SIZE), spacing, seed=seed), (1.0,))
    else:
        pattern, k = LATTICES[name]
        network = pulled(fill_rotated(pattern, Box(SIZE), spacing, np.radians(turn)), k)
    at, middle = crossings(network.points, network.springs, SIZE[1] / 2 + height), middles(network)
    clamped = np.abs(middle[:, 1] - SIZE[1] / 2) > SIZE[1] / 2 - 2
    found = grow(
        network, np.where(clamped, np.inf, 0.01), 1e3, crack=np.flatnonzero(at <= LENGTH),
        most_breaks=round(120 / spacing) if name == "Voronoi" else 120,
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
    row = ROWS.get(name, np.inf)
    return {
        "lattice": name, "turn": turn, "height": height, "spacing": spacing, "seed": seed,
        "direction": angle,
        "off_row": (angle - turn + row / 2) % row - row / 2 if name in ROWS else 0.0,
        "width": float(np.sqrt((apart**2).mean())) / spacing,
    }, ends - [LENGTH, SIZE[1] / 2 + height]  # fmt: skip


def run(grow: Grow, setting: kit.Setting) -> kit.Evidence:
    """Paths by lattice, turn, place, spacing and seed."""
    heights = (HEIGHTS[0], *NEW) if setting.quick else (*HEIGHTS, *NEW)
    turns = TURNS if setting.quick else (*TURNS, ("square-8", 22.5), ("square-8", 35.0))
    cases = [(*turn, height, 1.0, 0) for turn in turns for height in heights]
    cases.append(("square-8", 10.0, HEIGHTS[0], 0.5, 0))
    seeds = range(3) if setting.quick else range(8)
    sizes = (1.0,) if setting.quick else (1.0, 0.5)
    cases += [("Voronoi", 0.0, 0.0, size, setting.seed + k) for size in sizes for k in seeds]
    beside = [(*turn, height, 1.0, 0) for turn in ZIGZAG for height in heights[:2]]
    found = setting.sweep(partial(path_of, grow), [*cases, *beside], "paths")
    paths = pd.DataFrame([row for row, _ in found])
    breaks = [
        pd.DataFrame(ends.reshape(-1, 4), columns=list(ENDS)).assign(lattice=title(name, turn))
        for (name, turn, height, spacing, seed), (_, ends) in zip(cases, found, strict=False)
        if spacing == 1.0 and (height == HEIGHTS[0] or (name, seed) == ("Voronoi", setting.seed))
    ]
    random = paths[paths["lattice"] == "Voronoi"]
    spread = ", ".join(
        f"{own['direction'].mean():.0f} ± {own['direction'].std():.0f}° at a spacing of {size:g} "
        f"({own['width'].mean() * float(str(size)):.1f} wide)"
        for size, own in random.groupby("spacing", sort=False)
    )
    turned = paths.iloc[: len(cases)].query("lattice != 'Voronoi'")
    rows = ", ".join(
        f"{panel}: {' or '.join(f'{way:g}°' for way in sorted(set((2 * own).round() / 2 + 0.0)))}"
        for panel, own in turned.groupby(
            [title(*each) for each in zip(turned["lattice"], turned["turn"], strict=True)],
            sort=False,
        )["direction"]
    )
    astray = paths["direction"].iloc[len(cases) :]
    finding = (
        "Elasticity lets a crack in a pulled strip go straight on, at 0°. In turned lattices it "
        f"runs along rows, wherever it begins ({rows}), within {turned['off_row'].abs().max():.1f}°"
        "; in triangular turned by 10 and 20° it follows none, but goes in zigzag at "
        f"{astray.min():.0f} to {astray.max():.0f}°. Random lattices break in a cloud in place of "
        f"a crack: {spread}, over {len(seeds)} seeds."
    )
    return kit.Evidence(
        {"paths": paths.loc[: len(cases) - 1], "breaks": pd.concat(breaks, ignore_index=True),
         "zigzag": paths.loc[len(cases) :].reset_index(drop=True)},
        tolerances=RULES, columns=kit.columns(__file__), findings=(finding,),
        figures={"paths": draw_paths},
    )  # fmt: skip


def title(name: str, turn: float) -> str:
    """What a panel is called."""
    return name if name == "Voronoi" else f"{name} at {turn:g}°"


def draw_paths(tables: kit.Tables) -> Figure:
    """Springs that broke, ahead of a crack that elasticity lets go straight on."""
    groups = list(tables["breaks"].groupby("lattice", sort=False))
    rows = -(-len(groups) // 3)
    figure, axes = kit.figures.new_figure(3, rows, size=(2.45, 2.7))
    for axis, (name, own) in zip(axes, groups, strict=False):
        ends = own[list(ENDS)].to_numpy().reshape(-1, 2, 2)
        axis.add_collection(LineCollection(list(ends), colors=kit.figures.COLOURS[1]))
        axis.set(xlim=(0, 23), ylim=(-10.5, 10.5), title=name, aspect="equal")
        axis.set(xlabel="ahead of the tip (spacings)", ylabel="above it (spacings)")
    for axis in axes[len(groups) :]:
        axis.remove()
    figure.suptitle(str(draw_paths.__doc__).rstrip("."))
    return figure
