"""Air: how much of the marginal effect is left of a dielectric that lies in air?

Question   The model in one medium takes the permittivity of the slab all around it. How far is the
           upper face from that of a slab whose permittivity is 3 or 10 times that of the air?
Candidate  The springs' linear response to forces of free and bound charge on the slab's faces.
Reference  Finite elements of slab and air, Maxwell's stress of both as nodal forces.
Expected   Field lines leave the slab the less, the larger its permittivity: less charge at the
           edges and less force on them, so the margin sinks less, and the middle as before.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit

from . import bodies, profile
from .bodies import COVERED, HEIGHT, ActuatorSolver, body, elastic, linear_response, upper_face
from .profile_drawing import TITLES, broken

RATIOS, QUICK_RATIOS = (1.0, 3.0, 10.0), (3.0,)
LAYERS, QUICK_LAYERS = (10, 20), (6, 12)
MESH, QUICK_MESH = 32, 16
BESIDE = 0.2 * HEIGHT
"""Distance (m) inside an edge at which the marginal effect is read."""
RULES = (
    kit.Rule(
        "slab in air, away from edges: uncertainty of FEM, over the largest |u|", 0.005, "1",
        "half of what 20 layers may be off",
        table="air", value="air_uncertainty",
    ),
)  # fmt: skip


LINEAR: ActuatorSolver = partial(linear_response, None)
"""Newton's method would want derivatives of forces in air, which take minutes by differences."""


def run(candidate: ActuatorSolver = LINEAR, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Compare the upper faces for every ratio of permittivities."""
    quick = setting.quick
    layers, mesh = (QUICK_LAYERS, QUICK_MESH) if quick else (LAYERS, MESH)
    ratios = QUICK_RATIOS if quick else RATIOS
    found = [compare_faces(candidate, c, r, layers, mesh) for c in COVERED for r in ratios]
    table = pd.concat([rows for rows, _ in found], ignore_index=True)
    return kit.Evidence(
        tables={"air": table, "air_faces": pd.concat([f for _, f in found], ignore_index=True)},
        tolerances=(*RULES, *judge(table)),
        figures={"air": drawing},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def compare_faces(
    candidate: ActuatorSolver, covered: str, ratio: float, layers: tuple[int, ...], mesh: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Rows of a slab, and its upper face by springs and elements."""
    volts, rows = profile.VOLTAGE, list[dict[str, object]]()
    before: kit.Array | None = None
    scale = bodies.uniform_deflection(volts)
    finest = body(covered, layers[-1], ratio)
    top = upper_face(finest.network.points)
    across = finest.network.points[top, 0]
    coarse, fine = (elastic(m, finest, volts)[top] / scale for m in (mesh // 2, mesh))
    for n in layers:
        actuator = body(covered, n, ratio)
        at = upper_face(actuator.network.points)
        x, move = actuator.network.points[at, 0], candidate(actuator, volts)[at] / scale
        on = np.searchsorted(across, x - 1e-9)
        away = profile.edge_distance(covered, x) > profile.AWAY + 1e-9
        largest = profile.length(fine[on][away]).max()
        error = (move - fine[on]) / largest
        unsure = float(profile.length((fine - coarse)[on][away]).max() / largest)
        row: dict[str, object] = {"covered": covered, "permittivity_ratio": ratio, "layers": n}
        row |= {"air_difference": float(profile.length(error[away]).max()), "air_limit": "none"}
        if before is not None:
            limit = (2 * error[::2] - before)[away[::2]]
            row["air_limit"] = float(profile.length(limit).max())
        for suffix, u in (("", move), ("_fem", fine[on])):
            middle = u[len(x) // 2, 1]
            beside = np.interp(bodies.tips(covered)[0] + BESIDE, x, u[:, 1])
            row |= {f"air_middle{suffix}": -middle, f"air_beside{suffix}": beside / middle}
        rows.append(row | {"air_uncertainty": unsure})
        before = error
    apart = profile.edge_distance(covered, across) > 1e-9
    key = {"covered": covered, "permittivity_ratio": ratio, "x": across[apart]}
    faces = [
        pd.DataFrame(key | {"source": source, "uy": u[apart, 1]})
        for source, u in ((str(layers[-1]), move), ("FEM", fine))
    ]
    return pd.DataFrame(rows), pd.concat(faces, ignore_index=True)


def judge(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What is judged."""
    finest = table[table["layers"] == table["layers"].max()]
    limit = pd.to_numeric(finest["air_limit"], errors="coerce")
    return (
        kit.Tolerance(
            "slab in air, away from edges: springs - FEM times the layers, over the largest |u|",
            0.2, "1",
            "order 1 as in one medium: a tenth of a spring in half a height",
            layer="agreement",
            observed=kit.farthest_value(finest["air_difference"] * finest["layers"], 0.0),
        ),
        kit.Tolerance(
            "slab in air, away from edges: extrapolated with order 1 - FEM, over the largest |u|",
            0.01, "1",
            "what is left is of order 2: the square of 0.2 over 6 layers, what an edge is "
            "misplaced by, some times over as a face bends most beside it, and the reference's own "
            "error",
            observed=kit.farthest_value(limit, 0.0),
        ),
    )  # fmt: skip


def finding(table: pd.DataFrame) -> str:
    """What the air does to the marginal effect."""
    full = table[(table["covered"] == "full") & (table["layers"] == table["layers"].max())]
    parts = ", ".join(
        f"{beside:.2f} at a ratio of {ratio:g} (FEM {fem:.2f})"
        for ratio, beside, fem in zip(
            full["permittivity_ratio"], full["air_beside"], full["air_beside_fem"], strict=True
        )
    )
    beside = full.set_index("permittivity_ratio")["air_beside"]
    over = ": one medium all around overstates it" if beside.idxmax() == 1 < len(beside) else ""
    return (
        "The marginal effect of a fully covered slab, 2 m inside its edge over the middle, is "
        f"{parts}{over}."
    )


def drawing(tables: kit.Tables) -> Figure:
    """Deflection of the left half of the upper face for every ratio, springs over FEM."""
    table = tables["air_faces"]
    figure, axes = kit.figures.new_figure(len(COVERED), size=(3.6, 3.6), sharey=True)
    for axis, covered in zip(axes, COVERED, strict=True):
        rows = table[(table["covered"] == covered) & (table["x"] <= 30)]
        ratios = sorted(set(table["permittivity_ratio"]))
        for ratio, colour in zip(ratios, kit.figures.COLOURS, strict=False):
            here = rows[rows["permittivity_ratio"] == ratio]
            for source, line in here.groupby("source"):
                who, style, shown = "springs", ".", line
                if source == "FEM":
                    who, style, shown = "FEM", "-", broken(line[["x", "uy"]])
                label = f"{who}, ratio {ratio:g}"
                axis.plot(shown["x"], shown["uy"], style, color=colour, label=label)
        axis.set(xlabel="place along the slab, x (m)", ylim=(-3.2, 0.4), title=TITLES[covered])
    axes[0].set_ylabel("deflection uy\nover the uniform slab's (1)")
    figure.suptitle("The upper face of a slab in air, by permittivity over air's")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
