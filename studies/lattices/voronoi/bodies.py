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
from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import AXES_OF, cubic_part, isotropic_part
from msvalidate.springs.lattice import STIFFNESS_RULES, voronoi_box
from msvalidate.springs.lattice.point_sets import POINT_SETS

from ..cases import Solid
from . import drawing, networks, surfaces
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


def pooled_order(rows: pd.DataFrame) -> float:
    """Order of one body's deviation, mean over all families and loads."""
    mean = rows.groupby("spacings_a_side")["deviation"].mean()
    return kit.observed_order(1 / mean.index.to_numpy(dtype=float), mean)


RULES = (
    kit.Rule(
        "random bodies: difference from their solid times the spacings to a side, medians",
        6.0, "1",
        "a layer of one spacing on each of four sides that carries nothing changes a stretch by "
        "4 over the spacings to a side; a clamped side adds one, and the scatter of medians one",
        table="random_bodies", rows={"axes": 2},
        value=lambda rows: rows["springs_over_solid"] * rows["spacings_a_side"],
    ),
    kit.Rule(
        "random bodies: order of one body's deviation from its solid, mean of all kinds and loads",
        0.5, "1",
        "1 of a boundary layer, and of scatter in the plane; the mean of twelve medians of 6 "
        "bodies is known to a quarter, over a factor of four in size 0.25 of an order: twice that",
        table="random_bodies", rows={"axes": 2}, value=pooled_order, reference=1.0,
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    solid: Solid = homogenise,
) -> kit.Evidence:
    """Compare bodies with their solids, and look at their surfaces."""
    rules = ("A/L",) if setting.quick else STIFFNESS_RULES
    families: list[Family] = [(2, *kind) for kind in product(POINT_SETS, rules)]
    if not setting.quick:
        families += [(3, points, "A/L") for points in POINT_SETS]
    draws = seeds(setting, QUICK_DRAWS if setting.quick else DRAWS)
    sizes = {2: QUICK_CELLS if setting.quick else CELLS, 3: SOLID_CELLS}
    tensors = mean_tensors(solid, setting, families)
    cut = [family for family in families if family[1] in DIRECTED]
    materials = [tensors[family] for family in families]
    materials += [isotropic_part(tensors[family]) for family in cut]
    responses = setting.sweep(expected_response, materials, "bodies of random solids")
    own = dict(zip(families, responses, strict=False))
    isotropic = own | dict(zip(cut, responses[len(families) :], strict=True))
    bodies = [(family, n, s) for family in families for n in sizes[family[0]] for s in draws]
    found = iter(setting.sweep(partial(measure, candidate), bodies, "random bodies"))
    rows, rough = [], []
    for family in families:
        for n in sizes[family[0]]:
            drawn = [next(found) for _ in draws]
            standing = pd.DataFrame([body for body in drawn if body])
            head = dict(zip(("axes", "point_set", "stiffness"), family, strict=True))
            head |= {"spacings_a_side": n}
            rough.append(head | surfaces.mechanical(standing))
            head |= {"bodies": len(drawn), "mechanisms": len(drawn) - len(standing)}
            rows += [
                head | compare(load, standing[load], value, isotropic[family][0][load])
                for load, value in own[family][0].items()
            ]
    table = pd.DataFrame(rows)
    uncertainty = kit.Tolerance(
        "clamped body: uncertainty of the reference, relative", ACCURACY, "1",
        "what the question asks of it",
        observed=kit.farthest_value([off for _, off in responses], 0.0),
    )  # fmt: skip
    on_surfaces = surfaces.run(candidate, setting, pd.DataFrame(rough))
    compared = kit.Evidence(
        {"random_bodies": table},
        tolerances=(*RULES, uncertainty),
        figures={"random_bodies": drawing.BODIES},
        columns=kit.columns(__file__),
        findings=(finding(table[table["axes"] == 2]),),
    )
    return kit.merge(compared, on_surfaces)


def mean_tensors(solid: Solid, setting: kit.Setting, families: list[Family]) -> dict[Family, Any]:
    """Tensor of the endless networks of each family, at a spacing of 1 m, without its scatter.

    Uniform points and blue noise have no direction, jittered ones the axes of their grid.
    """
    sets = list(dict.fromkeys((dim, points) for dim, points, _ in families))
    rules = tuple(dict.fromkeys(rule for _, _, rule in families))
    cases = [(dim, points, COUNT[dim], seed) for dim, points in sets for seed in seeds(setting)]
    measured = partial(networks.measure, solid, rules=rules)
    found = setting.sweep(measured, cases, "solids of random bodies")
    table = pd.DataFrame([row for rows in found for row in rows])
    groups = table.groupby(["axes", "point_set", "stiffness"])["tensor"]
    part = {family: cubic_part if family[1] in DIRECTED else isotropic_part for family in families}
    return {f: part[f](np.mean(list(groups.get_group(f)), axis=0)) for f in families}


def measure(
    candidate: kit.DisplacementSolver, case: tuple[Family, int, int]
) -> dict[str, float] | None:
    """What one random body shows, by load; None if it is a mechanism."""
    (dim, points, rule), cells, seed = case
    box = kit.Box((1.0,) * dim)
    grid = voronoi_box(box, 1 / cells, points=points, stiffness=rule, seed=seed)
    x = grid.points
    problem = stretch(box)
    network = lattice_network(problem, grid, (1.0,))
    try:
        move = candidate(problem, network, "linear")
    except kit.SolverError:
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


def stretch(box: kit.Box) -> kit.Problem:
    """The box between tractions of 1 Pa on its left and right sides, supports without reactions."""
    d = box.dim
    corners = [(0.0,) * d, *(tuple(float(axis == up) for axis in range(d)) for up in range(1, d))]
    held: list[tuple[float | None, ...]] = [(0.0,) * d, (0.0, None, 0.0)[:d], (0.0, None, None)]
    supports = [kit.Support(kit.Region(at), part) for at, part in zip(corners, held, strict=False)]
    loads = tuple(
        kit.Traction(box.side(side), (pull,) + (0.0,) * (d - 1))
        for side, pull in (("right", 1.0), ("left", -1.0))
    )
    material = kit.Anisotropic(np.eye(3 * d - 3))
    return kit.Problem(box, material, tuple(supports), loads, "stretch")


def clamped_box(box: kit.Box, material: kit.Anisotropic | None = None) -> kit.Problem:
    """The plane box with its left side clamped, pulled and sheared at the right one."""
    held = (kit.Support(box.side("left"), (0.0, 0.0)),)
    loads = (kit.Traction(box.side("right"), (PULL, SHEAR)),)
    return kit.Problem(box, material or kit.Anisotropic(np.eye(3)), held, loads, name="clamped")


def tip(network: kit.Network, move: kit.Array, axis: int) -> float:
    """Mean displacement (m) along an axis of what is loaded, each point by its part of the load."""
    force = network.force[:, axis]
    return float(force @ move[:, axis] / force[force > 0].sum())


def expected_response(tensor: kit.Array) -> tuple[dict[str, float], float]:
    """What a body of a tensor shows, by load, and the uncertainty of finite elements."""
    compliance = np.linalg.inv(tensor)
    d = AXES_OF[len(tensor)]
    along, lateral = compliance[0, 0], compliance[1:d, 0].mean()
    exact = dict(zip(STRETCH, (float(1 / along), float(-lateral / along)), strict=True))
    if d == 3:
        return exact, 0.0
    box = kit.Box((1.0, 1.0))
    problem = clamped_box(box, kit.Anisotropic(tensor))
    edge = np.linspace(0, 1, 401)
    points = np.column_stack([np.ones_like(edge), edge])

    def tips(cells: int) -> kit.Array:
        mesh = reference_fem.box_discretisation(box, cells, "Q2", 2.0)
        move = reference_fem.solve_problem(problem, mesh).at(points)
        return np.asarray(np.trapezoid(move, edge, axis=0))

    size = np.abs(tips(MESH))
    found = reference_fem.refine(lambda cells: tips(cells) / size, MESH, ACCURACY / 2)
    exact |= dict(zip(CLAMPED, (found.value * size).tolist(), strict=True))
    return exact, float((found.uncertainty / found.value).max())


def compare(load: str, seen: pd.Series, value: float, isotropic: float) -> dict[str, Any]:
    """One row of the table `random_bodies`, of bodies of one family and size."""
    low, middle, high = np.quantile(seen, (0.25, 0.5, 0.75))
    return {
        "body_load": load,
        "in_springs": middle,
        "in_solid": value,
        "springs_over_solid": middle / value - 1,
        "deviation": (seen / value - 1).abs().median(),
        "from_isotropic": middle / isotropic - 1,
        "scatter": (high - low) / 2 / value,
    }


def finding(plane: pd.DataFrame) -> str:
    """How near bodies come to their solids."""
    mean = plane.groupby("spacings_a_side")["deviation"].mean()
    seen = ", ".join(f"{100 * value:.1f} % ({cells} spacings)" for cells, value in mean.items())
    kind = (plane["point_set"] == "jittered") & (plane["stiffness"] == "A/L")
    cut = plane[kind & (plane["body_load"] == STRETCH[0])].iloc[-1]
    return (
        f"A box of random points comes to the solid of its endless network with an order of "
        f"{pooled_order(plane):.2f}: stretches and tips of one body are typically {seen} "
        f"away. Jittered points keep the axes of the grid that they were strewn in: with A/L their "
        f"modulus along it, at {cut['spacings_a_side']} spacings, is "
        f"{100 * cut['springs_over_solid']:+.1f} % from that of the network's own mean tensor and "
        f"{100 * cut['from_isotropic']:+.1f} % from the nearest isotropic body's."
    )
