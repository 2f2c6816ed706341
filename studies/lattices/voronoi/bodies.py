"""Random bodies: is a body filled with a Voronoi network the solid that the endless network is?

Question   A box of random points, some of them on its sides, stretched between tractions, and with
           one side clamped under pull and shear: how far from the body with the endless network's
           mean tensor, does the difference go away as the box has more points, and is an isotropic
           body as good?
Candidate  Linear equilibrium of the spring network; the tensor is that of the candidate's solid.
Reference  Uniform stress in closed form; finite elements where a side is clamped.
Expected   A layer at the boundary has other neighbours than the inside, an error of first order in
           the spacing; scatter falls with the root of the number of points, in the plane of first
           order too.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

import reference_fem
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import AXES_OF, cubic_part, isotropic_part
from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.lattice import STIFFNESS_RULES, voronoi_box
from msvalidate.lattice.point_sets import POINT_SETS
from msvalidate.network import Network
from msvalidate.problem import (
    Anisotropic,
    Array,
    Box,
    Problem,
    Region,
    SolverError,
    Support,
    Traction,
)

from ..cases import Solid
from . import drawing, networks, solids, surfaces
from .networks import seeds

CELLS, QUICK_CELLS = (8, 16, 32), (5, 10, 20)
"""Spacings to a side of the box."""
SOLID_CELLS = (3, 6)
"""The same of a cube, in the full form."""
DRAWS, QUICK_DRAWS = 16, 6
COUNT = {2: 400, 3: 216}
"""Points of the periodic cells that the mean moduli are of."""
ACCURACY = 1e-3
"""Of the finite elements, relative: far below what is judged."""
MESH = 6
PULL, SHEAR = 1.0, 0.5
"""Tractions (Pa) on the side opposite to the clamped one; the answer is linear."""
STRETCH = ("stretch: modulus", "stretch: ratio")
CLAMPED = ("clamped: pull", "clamped: shear")
DIRECTED = ("jittered",)
"""Kinds of point set with directions, those of the axes."""
Family = tuple[int, str, str]
"""Axes, kind of point set, rule of stiffness."""
TOLERANCES = (
    Tolerance(
        "random bodies: difference from their solid times the spacings to a side, medians",
        6.0, "1",
        "a layer of one spacing on each of four sides that carries nothing changes a stretch by "
        "4 over the spacings to a side; a clamped side adds one, and the scatter of medians one",
    ),
    Tolerance(
        "random bodies: order of one body's deviation from its solid, mean of all kinds and loads",
        0.5, "1",
        "1 of a boundary layer, and of scatter in the plane; the mean of twelve medians of 6 "
        "bodies is known to a quarter, over a factor of four in size 0.25 of an order: twice that",
    ),
    Tolerance(
        "clamped body: uncertainty of the reference, relative", ACCURACY, "1",
        "what the question asks of it",
    ),
)  # fmt: skip
COLUMNS = {
    **{key: solids.COLUMNS[key] for key in ("axes", "point_set", "stiffness")},
    "spacings_a_side": "mean spacings to a side of the box (1)",
    "bodies": "random bodies drawn (1)",
    "mechanisms": "of these left out: some point moves without stretching a spring (1)",
    "body_load": "how the body is loaded, and what is measured",
    "in_springs": "median over the bodies: modulus (N/m in the plane, Pa in space at a spacing of "
    "1 m), ratio (1), or displacement under 1 Pa of pull and 0.5 Pa of shear (m)",
    "in_solid": "the same of the body with the endless network's mean tensor (as in_springs)",
    "springs_over_solid": "in_springs over in_solid less 1 (1)",
    "deviation": "distance of one body from in_solid, median over the bodies, over in_solid (1)",
    "from_isotropic": "in_springs over the same of the nearest isotropic body, less 1 (1)",
    "scatter": "half the distance of the quartiles over the bodies, over in_solid (1)",
    "body_order": "slope of log|springs_over_solid| against log(1/spacings_a_side), or "
    '"changes sign" (1)',
}


def run(
    candidate: DisplacementSolver = solve_springs,
    setting: Setting = FULL,
    solid: Solid = homogenise,
) -> Evidence:
    """Compare bodies with their solids, and look at their surfaces."""
    rules = ("A/L",) if setting.quick else STIFFNESS_RULES
    families: list[Family] = [(2, *kind) for kind in product(POINT_SETS, rules)]
    if not setting.quick:
        families += [(3, points, "A/L") for points in POINT_SETS]
    draws = seeds(setting, QUICK_DRAWS if setting.quick else DRAWS)
    sizes = {2: QUICK_CELLS if setting.quick else CELLS, 3: SOLID_CELLS}
    tensors = mean_tensors(solid, setting, families, seeds(setting))
    cut = [family for family in families if family[1] in DIRECTED]
    materials = [tensors[family] for family in families]
    materials += [isotropic_part(tensors[family]) for family in cut]
    references = setting.sweep(expected_response, materials, "bodies of random solids")
    own = dict(zip(families, references, strict=False))
    isotropic = own | dict(zip(cut, references[len(families) :], strict=True))
    bodies = [(family, n, s) for family in families for n in sizes[family[0]] for s in draws]
    found = iter(setting.sweep(partial(measure, candidate), bodies, "random bodies"))
    rows, rough = [], []
    for family in families:
        for n in sizes[family[0]]:
            drawn = [next(found) for _ in draws]
            rows += compare_sizes(family, n, drawn, own[family][0], isotropic[family][0])
            rough.append(surfaces.mechanical(family, n, [body for body in drawn if body]))
    table = pd.DataFrame(rows)
    groups = table.groupby(["axes", "point_set", "stiffness", "body_load"], sort=False)
    orders = pd.DataFrame([approach(line) for _, line in groups])
    plane_rows = table[table["axes"] == 2]
    values = (
        farthest_value(plane_rows["springs_over_solid"] * plane_rows["spacings_a_side"], 0.0),
        pooled_order(plane_rows),
        farthest_value([uncertainty for _, uncertainty in references], 0.0),
    )
    geometry, judged = surfaces.geometrical(setting)
    sample = surfaces.surface_rows(candidate, setting)
    return Evidence(
        tables={
            "random_bodies": table,
            "random_bodies_order": orders,
            "random_surface": geometry,
            "random_surface_loaded": pd.DataFrame(rough),
            "random_networks": sample,
        },
        observed=by_quantity(TOLERANCES, values) | judged,
        tolerances=(*TOLERANCES, *surfaces.TOLERANCES),
        figures={
            "random_bodies": drawing.bodies,
            "random_networks": drawing.networks,
        },
        columns=COLUMNS | surfaces.COLUMNS,
        findings=(
            finding(plane_rows),
            surfaces.finding(geometry, pd.DataFrame(rough)),
        ),
    )


def mean_tensors(
    solid: Solid, setting: Setting, families: list[Family], drawn: list[int]
) -> dict[Family, Array]:
    """Tensor of the endless networks of each family, at a spacing of 1 m, without its scatter.

    Uniform points and blue noise have no direction, jittered ones the axes of their grid.
    """
    sets = list(dict.fromkeys((dim, points) for dim, points, _ in families))
    rules = tuple(dict.fromkeys(rule for _, _, rule in families))
    cases = [(dim, points, COUNT[dim], seed) for dim, points in sets for seed in drawn]
    measured = partial(networks.measure, solid, rules=rules)
    found = setting.sweep(measured, cases, "solids of random bodies")
    table = pd.DataFrame([row for rows in found for row in rows])
    groups = table.groupby(["axes", "point_set", "stiffness"])["tensor"]
    mean = {family: np.mean(list(groups.get_group(family)), axis=0) for family in families}
    return {
        family: cubic_part(tensor) if family[1] in DIRECTED else isotropic_part(tensor)
        for family, tensor in mean.items()
    }


def measure(
    candidate: DisplacementSolver, case: tuple[Family, int, int]
) -> dict[str, float] | None:
    """What one random body shows, by load; None if it is a mechanism."""
    (dim, points, rule), cells, seed = case
    box = Box((1.0,) * dim)
    grid = voronoi_box(box, 1 / cells, points=points, stiffness=rule, seed=seed)
    x = grid.points
    problem = stretch(box)
    network = lattice_network(problem, grid, (1.0,))
    try:
        move = candidate(problem, network, "linear")
    except SolverError:
        return None
    strain = tip(network, move, 0)
    sides = [[move[x[:, axis] == end, axis].mean() for end in (1, 0)] for axis in range(1, dim)]
    lateral = np.mean([high - low for high, low in sides])
    seen = {
        # A network of one constant has the modulus of its spacing: 1/h times that at 1 m in space.
        STRETCH[0]: 1 / strain / cells ** (dim - 2),
        STRETCH[1]: -lateral / strain,
        "roughness": surfaces.roughness(x, move, cells / strain),
    }
    if dim == 2:
        problem = clamped_box(box)
        network = lattice_network(problem, grid, (1.0,))
        move = candidate(problem, network, "linear")
        seen |= {load: tip(network, move, axis) for axis, load in enumerate(CLAMPED)}
    return seen


def stretch(box: Box) -> Problem:
    """The box between tractions of 1 Pa on its left and right sides, supports without reactions."""
    corners = [
        Region(tuple(0.0 if axis != up else 1.0 for axis in range(box.dim)))
        for up in range(1, box.dim)
    ]
    held: list[tuple[float | None, ...]] = (
        [(0.0, None)] if box.dim == 2 else [(0.0, None, 0.0), (0.0, None, None)]
    )
    supports = [Support(Region((0.0,) * box.dim), (0.0,) * box.dim)]
    supports += [Support(at, part) for at, part in zip(corners, held, strict=True)]
    along = (1.0,) + (0.0,) * (box.dim - 1)
    loads = (
        Traction(box.side("right"), along),
        Traction(box.side("left"), tuple(-value for value in along)),
    )
    return Problem(box, Anisotropic(np.eye(3 * box.dim - 3)), tuple(supports), loads, "stretch")


def clamped_box(box: Box, material: Anisotropic | None = None) -> Problem:
    """The plane box with its left side clamped, pulled and sheared at the right one."""
    return Problem(
        box,
        material or Anisotropic(np.eye(3)),
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), (PULL, SHEAR)),),
        name="clamped",
    )


def tip(network: Network, move: Array, axis: int) -> float:
    """Mean displacement (m) along an axis of what is loaded, each point by its part of the load."""
    force = network.force[:, axis]
    return float(force @ move[:, axis] / force[force > 0].sum())


def expected_response(tensor: Array) -> tuple[dict[str, float], float]:
    """What a body of a tensor shows, by load, and its uncertainty where finite elements say it."""
    compliance = np.linalg.inv(tensor)
    d = AXES_OF[len(tensor)]
    lateral = compliance[1:d, 0].mean()
    exact = {
        STRETCH[0]: float(1 / compliance[0, 0]),
        STRETCH[1]: float(-lateral / compliance[0, 0]),
    }
    if d == 3:
        return exact, 0.0
    box = Box((1.0, 1.0))
    problem = clamped_box(box, Anisotropic(tensor))
    edge = np.linspace(0, 1, 401)
    points = np.column_stack([np.ones_like(edge), edge])

    def tips(cells: int) -> Array:
        mesh = reference_fem.box_discretisation(box, cells, "Q2", 2.0)
        move = reference_fem.solve_problem(problem, mesh).at(points)
        return np.asarray(np.trapezoid(move, edge, axis=0))

    size = np.abs(tips(MESH))
    found = reference_fem.refine(lambda cells: tips(cells) / size, MESH, ACCURACY / 2)
    exact |= dict(zip(CLAMPED, (found.value * size).tolist(), strict=True))
    return exact, float((found.uncertainty / found.value).max())


def compare_sizes(
    family: Family,
    cells: int,
    drawn: list[dict[str, float] | None],
    own: dict[str, float],
    isotropic: dict[str, float],
) -> list[dict[str, Any]]:
    """Rows of the table `random_bodies` of one family and size."""
    standing = pd.DataFrame([body for body in drawn if body])
    dim, points, rule = family
    rows = []
    for load, value in own.items():
        low, middle, high = np.quantile(standing[load], (0.25, 0.5, 0.75))
        rows.append(
            {
                "axes": dim,
                "point_set": points,
                "stiffness": rule,
                "spacings_a_side": cells,
                "bodies": len(drawn),
                "mechanisms": len(drawn) - len(standing),
                "body_load": load,
                "in_springs": middle,
                "in_solid": value,
                "springs_over_solid": middle / value - 1,
                "deviation": (standing[load] / value - 1).abs().median(),
                "from_isotropic": middle / isotropic[load] - 1,
                "scatter": (high - low) / 2 / value,
            }
        )
    return rows


def approach(rows: pd.DataFrame) -> dict[str, Any]:
    """One row of the table `random_bodies_order`."""
    gap = rows["springs_over_solid"].to_numpy()
    one_way = (gap > 0).all() or (gap < 0).all()
    order: float | str = (
        observed_order(1 / rows["spacings_a_side"], gap) if one_way else "changes sign"
    )
    head = ("axes", "point_set", "stiffness", "body_load")
    return {key: rows[key].iloc[0] for key in head} | {"body_order": order}


def pooled_order(rows: pd.DataFrame) -> Observed:
    """Order of one body's deviation, mean over all families and loads."""
    mean = rows.groupby("spacings_a_side")["deviation"].mean()
    return Observed(observed_order(1 / mean.index.to_numpy(dtype=float), mean.to_numpy()), 1.0)


def finding(plane: pd.DataFrame) -> str:
    """How near bodies come to their solids."""
    mean = plane.groupby("spacings_a_side")["deviation"].mean()
    seen = ", ".join(f"{100 * value:.1f} % ({cells} spacings)" for cells, value in mean.items())
    cut = plane[
        (plane["point_set"] == "jittered")
        & (plane["stiffness"] == "A/L")
        & (plane["body_load"] == STRETCH[0])
    ].iloc[-1]
    return (
        f"A box of random points comes to the solid of its endless network with an order of "
        f"{pooled_order(plane).value:.2f}: stretches and tips of one body are typically {seen} "
        f"away. Jittered points keep the axes of the grid that they were strewn in: with A/L their "
        f"modulus along it, at {cut['spacings_a_side']} spacings, is "
        f"{100 * cut['springs_over_solid']:+.1f} % from that of the network's own mean tensor and "
        f"{100 * cut['from_isotropic']:+.1f} % from the "
        f"nearest isotropic body's."
    )
