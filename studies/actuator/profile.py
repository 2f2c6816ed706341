"""Profile: is the upper face of the charged springs that of the elastic slab, at low voltage?

Question   Displacement of the upper face, fully and partly covered, against finite elements, for
           lattices of 5 to 40 layers; and what happens at the electrode's edges.
Candidate  The actuator at rest at a voltage, in one medium all around (the plane model).
Reference  Finite elements: Maxwell's stress of the field in the same medium as forces on the nodes
           of a linear elastic slab with the lattice's own tensor. They share no code.
Expected   Order 1 away from the edges: even charges on even springs place each edge to a part of a
           spring. At an edge the field pulls with a finite force on a single point, along the
           electrode, F = dW/dx of the edge. Under it the displacement grows without end, by
           F·c·ln 2 with each halving of the lattice, c of a straight face or of a square corner:
           what a mesh shows *at* the edge is the mesh's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
import pandas as pd

from msvalidate import kit

from . import bodies, edges, profile_drawing
from .bodies import COVERED, HEIGHT, ActuatorSolver, body, elastic, tips, upper_face

SAID = {"full": "fully covered", "partial": "covered in the middle"}
VOLTAGE = 0.01
"""V: strains of 3e-7, so that what is not linear is nothing beside any tolerance here."""
LAYERS, QUICK_LAYERS = (5, 10, 20, 40), (3, 6, 12, 24)
MESH, QUICK_MESH = 32, 24
"""Layers of the reference's finer mesh; its change from half as many is its uncertainty."""
AWAY = 0.5 * HEIGHT
"""Distance (m) from an edge beyond which a point counts as away from it."""
WITHIN, EXTRAPOLATED = 0.01, 0.003
RULES = (
    kit.Rule(
        "profile away from edges: uncertainty of FEM, over the largest |u|", 0.5 * WITHIN, "1",
        "half of what springs may be off; it is largest next to the edges",
        table="profile", value="uncertainty",
    ),
)  # fmt: skip

Face = dict[str | int, tuple[kit.Array, kit.Array, kit.Array]]
"""Layers, or "FEM" -> places (p,) in m, displacements (p, 2) and their uncertainties (p, 2), over
a uniform slab's deflection."""


def run(candidate: ActuatorSolver, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Compare the upper faces, and follow what happens at the edges."""
    return evidence(solve_faces(candidate, setting))


def solve_faces(
    candidate: ActuatorSolver, setting: kit.Setting, slabs: tuple[str, ...] = tuple(COVERED)
) -> dict[str, Face]:
    """Upper faces of the slabs named, on every lattice and by finite elements."""
    layers = QUICK_LAYERS if setting.quick else LAYERS
    mesh = QUICK_MESH if setting.quick else MESH
    solids = {covered: solid(covered, layers[-1], mesh) for covered in slabs}
    return {c: lattices(candidate, c, layers) | {"FEM": solids[c]} for c in slabs}


def evidence(faces: Mapping[str, Face]) -> kit.Evidence:
    """What upper faces show."""
    profile = pd.concat([compare_faces(c, face) for c, face in faces.items()], ignore_index=True)
    edge = pd.concat([edge_rows(c, face) for c, face in faces.items()], ignore_index=True)
    return kit.Evidence(
        tables={"profile": profile, "edges": edge},
        tolerances=(*RULES, *judge(profile, edge)),
        drawn={
            "surface": pd.concat(
                [faces_to_draw(*face) for face in faces.items()], ignore_index=True
            )
        },
        figures={"profile": profile_drawing.profiles, "profile_order": profile_drawing.orders},
        columns=kit.columns(__file__),
        findings=findings(profile, edge),
    )


def lattices(candidate: ActuatorSolver, covered: str, layers: tuple[int, ...]) -> Face:
    """Displacement of the upper face on every lattice."""
    found: Face = {}
    for n in layers:
        actuator = body(covered, n)
        points = actuator.network.points
        top = upper_face(points)
        move = candidate(actuator, VOLTAGE)[top] / bodies.uniform_deflection(VOLTAGE)
        found[n] = points[top, 0], move, np.zeros_like(move)
    return found


@cache
def solid(covered: str, layers: int, mesh: int) -> tuple[kit.Array, kit.Array, kit.Array]:
    """Displacement by finite elements at the upper points of a lattice, and its uncertainty."""
    actuator = body(covered, layers)
    points = actuator.network.points
    top, scale = upper_face(points), bodies.uniform_deflection(VOLTAGE)
    coarse, fine = (elastic(m, actuator, VOLTAGE)[top] / scale for m in (mesh // 2, mesh))
    return points[top, 0], fine, np.abs(fine - coarse)


def edge_distance(covered: str, x: kit.Array) -> kit.Array:
    """Distance (p,) in m of places along the upper face from the electrode's nearest edge."""
    return np.asarray(np.abs(x[:, None] - tips(covered)).min(axis=1))


def compare_faces(covered: str, face: Face) -> pd.DataFrame:
    """Rows of one slab: how far each lattice's face is from that of finite elements."""
    x, fem, unsure = face["FEM"]
    rows: list[dict[str, object]] = []
    before: tuple[int, float, kit.Array] | None = None
    for n in [key for key in face if key != "FEM"]:
        at, move, _ = face[n]
        on = np.searchsorted(x, at - 1e-9)
        away = edge_distance(covered, at) > AWAY + 1e-9
        near = ~away & (edge_distance(covered, at) > 0.1 * HEIGHT - 1e-9)
        scale = length(fem[on][away]).max()
        error = (move - fem[on]) / scale
        row: dict[str, object] = {"covered": covered, "layers": n, "spacing": HEIGHT / int(n)}
        row["difference_away"] = far = float(length(error[away]).max())
        row |= {"difference_times_layers": far * int(n), "order": "none", "extrapolated": "none"}
        if before is not None:
            skip = int(n) // before[0]
            row["order"] = kit.observed_order([2.0, 1.0], [before[1], far])
            limit = (2 * error[::skip] - before[2])[away[::skip]]
            row["extrapolated"] = float(length(limit).max())
        middle = len(at) // 2
        row |= {"difference_near": float(length(error[near]).max(initial=0.0))}
        row |= {"middle_springs": -move[middle, 1], "middle_fem": -fem[on][middle, 1]}
        rows.append(row | {"uncertainty": float(length(unsure[on][away]).max() / scale)})
        before = int(n), far, error
    return pd.DataFrame(rows)


def edge_rows(covered: str, face: Face) -> pd.DataFrame:
    """Rows of one slab: its right edge, which moves on as the lattice is halved."""
    exact = edges.growth(covered) / bodies.uniform_deflection(1.0)
    rows = []
    for axis, component in enumerate("xy"):
        seen = np.nan
        grown: list[float] = []
        if not exact[axis]:  # a force along a straight face moves its point along it
            continue
        for n in [key for key in face if key != "FEM"]:
            x, move, _ = face[n]
            value = float(move[np.abs(x - tips(covered)[1]).argmin(), axis])
            grown.append(value - seen)
            row: dict[str, object] = {"covered": covered, "component": component, "layers": n}
            row |= {"at_edge": value, "growth": _or_none(grown[-1])}
            row |= {"growth_extrapolated": _or_none(limit_of(grown)), "growth_exact": exact[axis]}
            rows.append(row)
            seen = value
    return pd.DataFrame(rows)


def limit_of(grown: list[float]) -> float:
    """Limit of the last three of values with terms of order 1/2 and 1; NaN of fewer."""
    if len(grown) < 3:
        return np.nan
    last = np.array(grown[-3:])
    for order in (0.5, 1.0):
        last = last[1:] + (last[1:] - last[:-1]) / (2**order - 1)
    return float(last[0])


def faces_to_draw(covered: str, face: Face) -> pd.DataFrame:
    """Displacements of the coarsest, the finest lattice and of finite elements, edges left out."""
    lattices = [key for key in face if key != "FEM"]
    tables = []
    for key in (lattices[0], lattices[-1], "FEM"):
        x, move, _ = face[key]
        apart = edge_distance(covered, x)
        keep: kit.Mask = (apart > 1e-9) | (key != "FEM")
        row = {"covered": covered, "source": str(key), "x": x[keep], "edge_distance": apart[keep]}
        tables.append(pd.DataFrame(row | {"ux": move[keep, 0], "uy": move[keep, 1]}))
    return pd.concat(tables, ignore_index=True)


def judge(profile: pd.DataFrame, edge: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What is judged."""
    finest = profile[profile["layers"] == profile["layers"].max()]
    fine = profile[2 * profile["layers"] >= profile["layers"].max()]
    last = edge[edge["layers"] == edge["layers"].max()]
    limit = pd.to_numeric(last["growth_extrapolated"], errors="coerce")
    return (
        kit.Tolerance(
            "profile away from edges: springs - FEM, finest lattice, over the largest |u|",
            WITHIN, "1",
            "what the project asks of springs against elements; an order 1 that leaves 2 % at 10 "
            "layers leaves 0.8 % at 24 and 0.5 % at 40",
            layer="agreement",
            observed=kit.farthest_value(finest["difference_away"], 0.0),
        ),
        kit.Tolerance(
            "profile away from edges: the same times the layers", 0.2, "1",
            "order 1 as of an edge misplaced by a part of a spring: a tenth of a spring in half a "
            "height, beyond which points count, is 0.2 over the layers; of the two finest lattices",
            layer="agreement",
            observed=kit.farthest_value(fine["difference_times_layers"], 0.0),
        ),
        kit.Tolerance(
            "profile away from edges: order in the spacing", 0.15, "1",
            "order 1 of even charges; terms of order 2 are a tenth of it on the two finest "
            "lattices",
            observed=kit.farthest_value(pd.to_numeric(finest["order"], errors="coerce"), 1.0),
        ),
        kit.Tolerance(
            "profile away from edges: extrapolated with order 1 - FEM, over the largest |u|",
            EXTRAPOLATED, "1",
            "the limit is the elastic slab; what is left is of order 2, the square of what an edge "
            "is misplaced by, 0.2 over the 12 layers of the coarser lattice, a few times over, and "
            "the reference's own error, up to 0.002 on its coarser meshes",
            observed=kit.farthest_value(pd.to_numeric(finest["extrapolated"], errors="coerce"),
            0.0),
        ),
        kit.Tolerance(
            "edges: growth by halving the lattice, over the closed form, extrapolated", 0.05, "1",
            "pressures that grow with the inverse root of the distance from an edge leave terms of "
            "order 1/2, a quarter at 24 layers, and their square, of order 1: both are taken out, "
            "and their cube is 2 %, times a factor of order 1",
            observed=kit.farthest_value(limit / last["growth_exact"], 1.0),
        ),
    )  # fmt: skip


def findings(profile: pd.DataFrame, edge: pd.DataFrame) -> tuple[str, ...]:
    """What the tables say: the agreement, and the edges."""
    finest = profile[profile["layers"] == profile["layers"].max()]
    parts = [
        f"{SAID[row.covered]} {100 * row.difference_away:.2f} % (order {row.order:.2f})"
        for row in finest.itertuples()
    ]
    agree = (
        "At low voltage the springs' upper face is the elastic slab's: half a height and more from "
        f"the electrode's edges, with {finest['layers'].iloc[0]} layers, {', '.join(parts)}."
    )
    down = edge[(edge["covered"] == "full") & (edge["component"] == "y")]
    if down.empty:  # the controls ask of one slab alone
        return (agree,)
    per = float(down["growth_exact"].iloc[0])
    tip = (
        "At the edges there is no limit: with each halving of the lattice the corner of the fully "
        f"covered slab sinks by another {-per:.2f} of the middle's deflection (springs "
        f"{-float(down['growth'].iloc[-1]):.2f} in the last halving), as under the finite force "
        "that the field's edge puts on a single point."
    )
    return agree, tip


def length(vectors: kit.Array) -> kit.Array:
    """(p,) of vectors (p, 2)."""
    return np.asarray(np.hypot(*vectors.T))


def _or_none(value: float) -> float | str:
    return float(value) if np.isfinite(value) else "none"
