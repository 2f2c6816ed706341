"""Pressed: how wide is the patch, and how large the pressure, by cells in a half-width?

Question   Half-width, peak pressure and forces of a rigid parabola on a block, by lattice cells; a
           block pressed by a disc to a tenth of its height.
Candidate  Exact unilateral contact of square-8 cells to first order, and of springs under tension
           on a mesh's edges at large strain.
Reference  Two small lattices with every set of touching points tried; a spectral pressure on the
           same finite block; elements by another algorithm; at large strain elements of the
           neo-Hookean law under the springs' contact forces.
Expected   Errors fall as the square of cells in a half-width, with where the patch ends between two
           points; counting touching points errs by a cell, which is its resolution.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from msvalidate import kit
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import contact_network
from msvalidate.springs.lattice import mesh_lattice, square
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.statics.contact import (
    ContactCandidates,
    ContactEquilibrium,
    ContactForces,
    solve_contact,
)
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem import contact as elements
from reference_fem.first_mesh import first_mesh
from reference_fem.large_strain import Solid, deform, neo_hookean
from reference_fem.mesh.discretisation import make_discretisation

Press = Callable[..., ContactEquilibrium]
"""(network, touching, geometry) -> what is at rest."""
Width = Callable[[ContactForces, float], float]
"""(contact, spacing) -> half-width (m)."""
E, NU, R = 8 / 3, 1 / 3, 100.0
W, H = 10, 20
"""Half the block's width and its height, in half-widths of the half-plane's patch."""
BLOCK = (-1.519e-3, 1.526e-3)
"""Half-width and peak pressure over the half-plane's, less 1, of the block at a half-width
of 1; they grow as its square. By a spectral pressure in an independent program, to 3e-6."""
APPROACH, SPECTRAL = 0.0198272, 3e-6
SMALL = (
    ((8, 4), 20.0, 4.0, 0.05, {3: 0.012948531336364994, 4: 0.06641243292067388,
                               5: 0.012948531336364975}),
    ((10, 6), 30.0, 5.3, 0.06, {4: 0.008313406041566947, 5: 0.05496623199673314,
                                6: 0.04211667167605116}),
)  # fmt: skip
"""Cells, radius, place and depth of a parabola, and forces by place: all sets of points tried."""
CELLS = (3, 5, 8, 16)
DEEP = (0.01, 0.05, 0.1)
"""Depth over the block's height."""
RULES = (
    kit.Rule(
        "small lattices: forces, over the largest", 1e-9, "1",
        "exact unilateral contact: gaps close to 1e-10 of the depth", table="small",
        value="force", reference="known",
    ),
    kit.Rule(
        "gap under a force, or penetration, over the depth", 1e-9, "1",
        "exact unilateral contact has none", table="small", value="open",
    ),
    kit.Rule(
        "uniform pressure of a flat obstacle on springs and elements, relative", 1e-12, "1",
        "a patch test: rounding", table="patch", value="spread",
    ),
    kit.Rule(
        "elements on the block: half-width, peak pressure, approach, relative", 1e-3, "1",
        "24 nodes in a half-width: the patch ends between two of them, (1/24)² / 2",
        table="elements", value="error",
    ),
    kit.Rule(
        "half-width, mean over loads that move the edge by a cell, times (cells/5)^1.5", 2.85e-3,
        "1", "points stand for a cell's surface: of second order but for where the patch ends",
        table="patches", value=lambda t: t["half_width"] * (t["cells"] / 5) ** 1.5,
        layer="regression",
    ),
    kit.Rule(
        "the same of the peak pressure, times (cells/5)^1.9", 2.5e-3, "1",
        "as the half-width, away from the edge", table="patches",
        value=lambda t: t["peak"] * (t["cells"] / 5) ** 1.9, layer="regression",
    ),
    kit.Rule(
        "half-width at the worst load, times (cells/8)²", 6e-3, "1",
        "a patch that ends midway between two points", table="patches",
        value=lambda t: t["worst"] * (t["cells"] / 8) ** 2, layer="regression",
    ),
    kit.Rule(
        "deep: springs against neo-Hookean elements under their forces, over the largest", 1e-9,
        "1", "springs of no rest length on a mesh's edges are those elements: rounding",
        table="deep", value="difference",
    ),
    kit.Rule(
        "deep: gap under a force, or penetration, over the depth", 1e-9, "1",
        "exact unilateral contact has none", table="deep", value="open",
    ),
)  # fmt: skip
FIGURES = {
    "pressures": kit.series(
        "pressures", title="Pressure under a parabola: 8 cells in a half-width", x="x",
        y={"springs": "springs", "elements": "elements", "hertz": "Hertz, half-plane"},
        size=(5.6, 3.8), labels=("place over half-width (1)", "pressure over Hertz's peak (1)"),
    ),
}  # fmt: skip


def run_small(candidate: Press) -> kit.Evidence:
    """Forces on small lattices, and a flat obstacle."""
    patch = [flat_patch(side, candidate) for side in ("springs", "elements")]
    tables = {"small": pd.DataFrame(small_lattices(candidate)), "patch": pd.DataFrame(patch)}
    return kit.Evidence(tables, tolerances=RULES[:3], columns=kit.columns(__file__))


def run_line(
    candidate: Press, setting: kit.Setting, width: Width, block: tuple[float, float]
) -> kit.Evidence:
    """Patches under a parabola by cells and load."""
    cells = CELLS[:2] if setting.quick else CELLS
    each = [(n, i) for n in cells for i in range(8)]
    line = pd.DataFrame(setting.sweep(partial(line_contact, candidate, width, block), each, "line"))
    patches = pd.DataFrame([_summary(n, own) for n, own in line.groupby("cells")])
    tables = {
        "line": line, "patches": patches, "elements": pd.DataFrame(element_errors()),
        "pressures": pd.DataFrame(pressures(candidate)),
    }  # fmt: skip
    five = patches.set_index("cells").loc[5]
    finding = (
        "Under a round obstacle 5 cells in the half-width of the patch give half-width and peak "
        f"pressure to {100 * max(abs(five['worst']), abs(five['peak'])):.1f} %, by the forces' "
        f"second moment; counting touching points errs by {100 * five['counted_least']:.0f} to "
        f"{100 * five['counted_most']:.0f} % there."
    )
    return kit.Evidence(
        tables, tolerances=RULES[3:7], columns=kit.columns(__file__), findings=(finding,),
        figures=FIGURES,
    )  # fmt: skip


def run_deep(candidate: Press) -> kit.Evidence:
    """A block pressed to a tenth of its height."""
    deep = pd.DataFrame([press_deep(candidate, part) for part in DEEP])
    last = deep.iloc[-1]
    finding = (
        "Pressed by a disc to a tenth of its height, springs under tension on a mesh's edges are "
        f"neo-Hookean elements to {last['difference']:.0e}; first-order contact has "
        f"{100 * (1 - last['force_linear'] / last['force']):.0f} % less of a force there."
    )
    return kit.Evidence(
        {"deep": deep}, tolerances=RULES[7:], columns=kit.columns(__file__), findings=(finding,)
    )


def second_moment(found: ContactForces, _spacing: float) -> float:
    """Half-width (m) by the forces' second moment."""
    return found.half_width


def counted(found: ContactForces, spacing: float) -> float:
    """Half-width (m) of a half model by the number of touching points."""
    return float((found.force > 0).sum() - 1) * spacing


def small_lattices(candidate: Press) -> list[dict[str, float]]:
    """Forces on the tops of two small blocks, over the largest."""
    rows = []
    for number, (cells, radius, at, depth, known) in enumerate(SMALL):
        box = kit.Box(tuple(float(n) for n in cells))
        top = kit.Obstacle("parabola", (at, box.size[1]), (0.0, -1.0), radius)
        problem = _problem(box, kit.Contact(box.side("top"), top, depth))
        network, touching = contact_network(problem, square(box, cells), (2.0, 1.0))
        found = candidate(network, touching, "linear")
        (one,), largest = found.contacts, max(known.values())
        for x, force in zip(network.points[one.points, 0], one.force, strict=True):
            row = {"number": number, "x": x, "force": force / largest}
            rows.append(row | {"known": known.get(round(x), 0.0) / largest})
            rows[-1]["open"] = found.complementarity
    return rows


def flat_patch(side: str, candidate: Press) -> dict[str, object]:
    """How far the pressure of a flat obstacle on a block of ratio 0 is from uniform."""
    box = kit.Box((0.74, 0.37))
    flat = kit.Obstacle("half_space", (0.0, 0.37), (0.0, -1.0))
    rollers = (kit.Support(box.side("bottom"), (None, 0.0)),
               kit.Support(kit.Region((0.0, 0.0)), (0.0, None)))  # fmt: skip
    material = kit.Isotropic(E, 0.0, thickness=0.2)
    contact = (kit.Contact(box.side("top"), flat, 1e-9 * 0.37),)
    problem = kit.Problem(box, material, rollers, contacts=contact)
    if side == "elements":
        pressure = elements.press(problem, first_mesh(problem)).pressure
    else:
        grid = square(box, (20, 10))
        network, touching = contact_network(problem, grid, calibrate_material(material, grid))
        pressure = candidate(network, touching, "linear").contacts[0].pressure
    return {"side": side, "spread": np.abs(pressure / (1e-9 * E) - 1).max()}


def _problem(box: kit.Box, contact: kit.Contact, *more: kit.Support) -> kit.Problem:
    clamp = kit.Support(box.side("bottom"), (0.0, 0.0))
    return kit.Problem(box, kit.Isotropic(E, NU), (clamp, *more), contacts=(contact,))


def _half_block(a: float) -> kit.Problem:
    """Half of the block under the force of which the half-plane's half-width is a (m)."""
    box = kit.Box((float(W), float(H)))
    top = kit.Obstacle("parabola", (0.0, float(H)), (0.0, -1.0), R)
    force = np.pi * E / (4 * R) * a**2 / 2
    contact = kit.Contact(box.side("top"), top, force=force)
    return _problem(box, contact, kit.Support(box.side("left"), (0.0, None)))


def _press_half(candidate: Press, cells: int, a: float) -> ContactForces:
    problem = _half_block(a)
    assert isinstance(problem.domain, kit.Box)  # noqa: S101  as `_half_block` has it
    network, touching = contact_network(problem, square(problem.domain, (W * cells, H * cells)))
    return candidate(network, touching, "linear").contacts[0]


def line_contact(
    candidate: Press, width: Width, block: tuple[float, float], case: tuple[int, int]
) -> dict[str, float]:
    """One of eight loads that move the patch's edge by a cell: errors against the block's own."""
    cells, number = case
    a = 1 + number / 8 / cells
    found = _press_half(candidate, cells, a)
    true_a, true_p = a * (1 + block[0] * a**2), E / (2 * R) * a * (1 + block[1] * a**2)
    return {
        "cells": cells, "load": a, "half_width": width(found, 1 / cells) / true_a - 1,
        "peak": found.pressure.max() / true_p - 1,
        "counted": counted(found, 1 / cells) / true_a - 1,
    }  # fmt: skip


def _summary(cells: object, own: pd.DataFrame) -> dict[str, object]:
    worst = own["half_width"].iloc[own["half_width"].abs().argmax()]
    return {
        "cells": cells, "half_width": own["half_width"].mean(), "peak": own["peak"].mean(),
        "worst": worst, "reference": SPECTRAL,
        "counted_least": own["counted"].min(), "counted_most": own["counted"].max(),
    }  # fmt: skip


def element_errors() -> list[dict[str, object]]:
    """Elements on the block at a half-width of 1, against the spectral pressure's values."""
    problem = _half_block(1.0)
    found = elements.press(problem, elements.contact_mesh(problem, 1.0, 12))
    peak = found.pressure.max() / (E / (2 * R)) / (1 + BLOCK[1])
    values = {"half-width": found.half_width / (1 + BLOCK[0]), "peak": peak,
              "approach": found.depth / APPROACH}  # fmt: skip
    return [{"quantity": name, "error": value - 1} for name, value in values.items()]


def pressures(candidate: Press) -> list[dict[str, object]]:
    """Pressure along the patch of 8 cells, of elements at the same places, and Hertz's."""
    springs, problem, peak = _press_half(candidate, 8, 1.0), _half_block(1.0), E / (2 * R)
    body = elements.press(problem, elements.contact_mesh(problem, 1.0, 8))
    order = np.argsort(body.points[:, 0], kind="stable")
    x = np.arange(len(springs.points)) / 8
    near = x <= 1.5
    rows = {
        "x": x[near], "springs": springs.pressure[near] / peak,
        "elements": np.interp(x[near], body.points[order, 0], body.pressure[order]) / peak,
        "hertz": np.sqrt(np.maximum(1 - x[near] ** 2, 0.0)),
    }  # fmt: skip
    return list(pd.DataFrame(rows).to_dict("records"))  # type: ignore[arg-type]


def press_deep(candidate: Press, part: float) -> dict[str, float]:
    """A block of triangles under a disc, and elements under the same forces."""
    box, n = kit.Box((0.74, 0.37)), 16
    grid = square(box, (2 * n, n))
    cells = np.asarray(grid.cells)[:, np.array([[0, 1, 2], [0, 2, 3]])].reshape(-1, 3)
    mesh = kit.Mesh(np.array(grid.points), cells, "triangle")
    material = kit.Isotropic(E, NU, "plane_strain", thickness=0.2)
    disc = kit.Obstacle("disc", (0.37, 0.37), (0.0, -1.0), 0.2)
    top = kit.Region((None, 0.37))
    clamp = (kit.Support(kit.Region((None, 0.0)), (0.0, 0.0)),)
    contact = (kit.Contact(mesh.part(top), disc, part * 0.37),)
    problem = kit.Problem(mesh, material, clamp, contacts=contact)
    edges = mesh_lattice(mesh, "cotangent", positive=False)
    found_constants = calibrate_material(material, edges, route="neo-Hookean")
    network, touching = contact_network(problem, edges, found_constants)
    found = candidate(network, touching, "nonlinear")
    u, one = found.equilibrium.displacement, found.contacts[0]
    x = network.points[one.points] + u[one.points]
    force = np.zeros_like(u)
    force[one.points] = one.force[:, None] * disc.normal(x, one.depth)
    body = make_discretisation(mesh.points, cells, "P1")
    solid = Solid(body, neo_hookean(material), network.fixed, material.thickness)
    theirs = deform(solid, 0 * u, force, parts=4, tolerance=1e-15, allow_locked=True).displacement
    small = candidate(network, touching, "linear").contacts[0]
    return {
        "depth": part, "force": one.total / (E * 0.2 * 0.37), "half_width": one.half_width / 0.37,
        "force_linear": small.total / (E * 0.2 * 0.37), "open": found.complementarity,
        "difference": np.abs(u - theirs).max() / np.abs(theirs).max(),
    }  # fmt: skip


# Faults: ways to press that are not exact contact -------------------------------------------------


def press_too_deep(
    network: Network, touching: tuple[ContactCandidates, ...], how: str
) -> ContactEquilibrium:
    """Contact whose gaps are 0.1 % of the depth too small."""
    return solve_contact(network, [replace(one, depth=1.001 * one.depth) for one in touching])


def press_by_penalty(
    network: Network, touching: tuple[ContactCandidates, ...], _how: str
) -> ContactEquilibrium:
    """One-sided springs, a hundred times as stiff as the network's own, in place of contact."""
    return _press_densely(network, touching[0], 1 / (100 * float(network.stiffness.max())))


def press_and_pull(
    network: Network, touching: tuple[ContactCandidates, ...], _how: str
) -> ContactEquilibrium:
    """Contact that also pulls, wherever the obstacle is in the body as it was."""
    return _press_densely(network, touching[0], 0.0, pulls=True)


def _press_densely(
    network: Network, one: ContactCandidates, give: float, *, pulls: bool = False
) -> ContactEquilibrium:
    free = ~network.fixed.ravel()
    gap = one.obstacle.gap(network.points[one.points], one.depth)
    inverse = np.linalg.inv(Configuration(network).tangent().toarray()[np.ix_(free, free)])
    at = (np.cumsum(free) - 1)[network.dim * one.points + 1]
    C = inverse[np.ix_(at, at)] + give * np.eye(len(at))
    force = np.zeros(len(at))
    if pulls:
        on = gap < 0
        force[on] = np.linalg.solve(C[np.ix_(on, on)], -gap[on])
    else:
        L = np.linalg.cholesky(C)
        force, _ = nnls(L.T, -np.linalg.solve(L, gap))
    load = np.array(network.force)
    load[one.points, 1] -= force
    found = equilibrium(replace(network, force=load))
    left = gap - found.displacement[one.points, 1]
    open_by = float(np.abs(left[force > 0]).max() / -gap.min())
    pressed = ContactForces(
        one.points, one.share, force, left, one.depth, float(force.sum()), np.nan
    )
    return ContactEquilibrium(found, load, (pressed,), open_by, 1, 0)


FAULTS: dict[str, dict[str, object]] = {
    "a contact that also pulls": {"candidate": press_and_pull, "questions": ("small",)},
    "gaps off by 0.1 % of the depth": {"candidate": press_too_deep, "questions": ("small",)},
    "a penalty in place of exact forces": {"candidate": press_by_penalty, "questions": ("small",)},
    "half-width by counting touching points": {"width": counted, "questions": ("line",)},
    "half-plane values for a small block": {"block": (0.0, 0.0), "questions": ("line",)},
}
