"""In air: a slab of rubber with air around it, by two methods that share no code.

Question   Capacitance of a slab between electrodes in air, and the forces on it, for permittivity
           ratios 1, 3 and 10 and a top that is covered in full or by a third.
Candidate  `SlabInAir`: free charge on electrodes, bound charge on bare faces, none elsewhere.
Reference  Finite elements of slab and air, Maxwell's stress as nodal forces. A far boundary that
           lets no field through takes energy away, a conductor without charge there adds some: the
           two bound the capacitance in endless air, and their mean is nearer by orders.
Expected   Capacitances within 0.2 %. Elements spread the force on an electrode's edge over nodes
           around it, so forces are compared as the work of smooth motions: one that is 1 on the
           electrode, or its edge, and falls to 0 within half the height. An edge in the open is
           pulled along with a force of its own. At a corner of the slab the field grows
           as r^(λ-1), tan²(λπ/2) = (1+3ε_r)/(3+ε_r), more slowly where the ratio is above 1: no
           force is left on the edge itself, and what lies within some radius goes with its power
           2λ-1. All that stretches half a slab is Maxwell's stress across its middle, ½ε(V/d)²·d
           at each ratio, but for what the field outside adds: air moves the margin's force
           from the edge to the face, and takes little of it away.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges.faces import slab_faces
from reference_fem.electric import FAR, Charged, Electrode, Far, Slab, slab_mesh, solve_charges

from .common import ChargeSolver

LENGTH = 6.0
"""Of the slab over its height."""
COVERED = (1.0, 1 / 3)
RATIOS = (1.0, 3.0, 10.0)
VOLTAGES = (0.5, -0.5)
SEGMENTS, QUICK_SEGMENTS = 320, 120
"""Of the bottom."""
LAYERS, QUICK_LAYERS = 24, 12
"""Cells of the finer mesh up the slab; the coarser one has half as many."""
REACHES = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Distances of the far boundary over the slab's length; the last is that of all other tables."""
REACHED = 0.5
"""How far from an electrode or its edge forces count as its own, over the height."""
RULES = (
    kit.Rule(
        "capacitance of a slab in air, moments against elements", 2e-3, "1",
        "graded segments leave some 1e-4, graded elements and the far boundary less",
        table="in_air", value="capacitance_difference",
    ),
    kit.Rule(
        "error of the far boundary: half of what its two kinds differ by, over the capacitance",
        2e-4, "1",
        "a dipole's energy outside falls with the square of the distance: (1/32)² times an eighth",
        table="in_air", value="boundary_error",
    ),
    kit.Rule(
        "change of the elements' capacitance with the last halving of cells", 2e-3, "1",
        "graded to the edges, its errors fall with order 3: what is left is a seventh of it",
        table="in_air", value="elements_change",
    ),
    kit.Rule(
        "pull on the top of a slab in air, moments against elements", 2e-3, "1",
        "as of the capacitance, whose derivative it is",
        table="in_air", value=kit.Quotient("pull", "pull_elements"), reference=1.0,
    ),
    kit.Rule(
        "stretch of half a slab in air, moments against elements", 5e-4, "1",
        "stress across the middle, where fields are even: what remains is the far boundary's part",
        table="in_air", value=kit.Quotient("stretch", "stretch_elements"), reference=1.0,
    ),
)  # fmt: skip


class Case(NamedTuple):
    """Part of the top that is covered, and permittivity ratio."""

    covered: float
    ratio: float


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Both methods on every slab."""
    cases = [Case(*case) for case in product(COVERED, RATIOS)]
    size = (QUICK_SEGMENTS, QUICK_LAYERS) if setting.quick else (SEGMENTS, LAYERS)
    table = pd.DataFrame(
        setting.sweep(partial(compare_with_elements, candidate, *size), cases, "slab in air")
    )
    box = partial(reference, Case(COVERED[0], 3.0), size[1] // 2)
    far = pd.DataFrame(
        {"reach": reach, "far": far, "capacitance_elements": float(box(far, reach).totals[0])}
        for reach, far in product(REACHES, FAR)
    )
    without = table[table["permittivity_ratio"] == 1].set_index("covered")["edge_work_elements"]
    scale = table["covered"].map(without)
    own = (
        kit.Tolerance(
            "force along at an edge of the top of a slab in air, moments against elements",
            2e-3, "of that without the jump of permittivity",
            "as of the capacitance, whose derivative it is too",
            observed=kit.farthest_value(table["edge_work"] / scale,
            table["edge_work_elements"] / scale),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"in_air": table, "far_boundary": far},
        tolerances=(*RULES, *own),
        figures={"in_air": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def reference(case: Case, layers: int, far: Far, reach: float = REACHES[-1]) -> Charged:
    """The slab in air by elements."""
    half = 0.5 * case.covered * LENGTH
    top = Electrode("top", LENGTH / 2 - half, LENGTH / 2 + half, VOLTAGES[0])
    bottom = Electrode("bottom", 0.0, LENGTH, VOLTAGES[1])
    slab = Slab(LENGTH, 1.0, (top, bottom), permittivity=1.0, air=1 / case.ratio)
    return solve_charges(slab_mesh(slab, layers, reach=reach * LENGTH), far=far)


def compare_with_elements(
    candidate: ChargeSolver, segments: int, layers: int, case: Case
) -> dict[str, object]:
    """Row of one slab."""
    faces = slab_faces(LENGTH, 1.0, segments, covered=case.covered)
    found = candidate.in_air(faces, ratio=case.ratio).charges(VOLTAGES)
    fine = [reference(case, layers, far) for far in FAR]
    coarse = float(reference(case, layers // 2, FAR[0]).totals[0])
    natural, floating = (float(one.totals[0]) for one in fine)
    elements = (natural + floating) / 2
    ours = sum_forces(faces.points - (0.0, 1.0), candidate.forces_in_air(found), case)
    theirs = sum_forces(*on_nodes(fine), case)
    return {
        "covered": case.covered,
        "permittivity_ratio": case.ratio,
        "capacitance_in_air": float(found.totals[0]),
        "capacitance_elements": elements,
        "capacitance_difference": float(found.totals[0]) / elements - 1,
        "boundary_error": abs(floating - natural) / (2 * elements),
        "elements_change": natural / coarse - 1,
        **ours,
        **{f"{name}_elements": load for name, load in theirs.items()},
    }


def on_nodes(fields: list[Charged]) -> tuple[kit.Array, kit.Array]:
    """Places (n, 2) from the middle of the top, and mean forces (n, 2), of nodes in and around."""
    mesh = fields[0].mesh
    inner = np.setdiff1d(np.arange(len(mesh.body.points)), mesh.far)
    force = sum((field.solution.forces[inner] for field in fields), np.zeros((len(inner), 2)))
    return mesh.body.points[inner] - (LENGTH / 2, 1.0), force / len(fields)


def sum_forces(points: kit.Array, forces: kit.Array, case: Case) -> dict[str, float]:
    """Pull on the top electrode, force along at its right edge, stretch of half, over wide plates'.

    Points (n, 2) are counted from the middle of the top.
    """
    half = 0.5 * case.covered * LENGTH
    beyond = np.abs(points[:, 0]) - half
    near_top = taper_forces(np.hypot(np.maximum(beyond, 0.0), points[:, 1]))
    near_edge = taper_forces(np.hypot(points[:, 0] - half, points[:, 1]))
    return {
        "pull": float(-forces[:, 1] @ near_top / (0.5 * 2 * half)),
        "edge_work": float(forces[:, 0] @ near_edge / 0.25),
        "stretch": float(forces[points[:, 0] > 1e-9, 0].sum() / 0.5),
    }


def taper_forces(distance: kit.Array) -> kit.Array:
    """1 at no distance, falling smoothly to 0 at `REACHED`."""
    return np.maximum(1 - (distance / REACHED) ** 2, 0.0) ** 2


def finding(table: pd.DataFrame) -> str:
    """How far both agree, and what the air makes of the margin, in sentences."""
    most = table["capacitance_difference"].abs().max()
    rows = table.set_index(["covered", "permittivity_ratio"])
    full, third = (rows.loc[covered] for covered in COVERED)
    lost = full["edge_work"]
    return (
        f"Slab in air: capacitances by charges and by elements differ by {most:.1e} at most. At a "
        f"ratio of 3 the force at the edge of a top that is covered in full is "
        f"{lost[1.0] / lost[3.0]:.1f} times smaller than without the jump, and all that stretches "
        f"half the slab {full['stretch'][3.0] / full['stretch'][1.0]:.3f} of it; covered by a "
        f"third, {third['edge_work'][1.0] / third['edge_work'][3.0]:.2f} times and "
        f"{third['stretch'][3.0] / third['stretch'][1.0]:.3f}."
    )


FAR_WORDS = {"natural": "no field through it", "floating": "a conductor without charge"}
"""Both kinds of far boundary."""
SHOWN = (
    ("capacitance_in_air", "capacitance_elements", "capacitance per depth,\nover ε (1)"),
    ("edge_work", "edge_work_elements", "outward force at\nan edge of the top,\nover εV²/(4d) (1)"),
    ("stretch", "stretch_elements", "outward force on\nhalf the slab,\nover εV²/(2d) (1)"),
)
"""What is drawn: by charges, by elements, and its label."""


def draw(tables: kit.Tables) -> Figure:
    """Capacitance, margin and stretch, and what the far boundary does."""
    table, far = tables["in_air"], tables["far_boundary"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.5, 2.8))
    *compared, box = axes
    for axis, (ours, theirs, name) in zip(compared, SHOWN, strict=True):
        for place, (covered, rows) in enumerate(table.groupby("covered", sort=False)):
            colour, part = kit.figures.COLOURS[place], f"{float(str(covered)):.0%} covered"
            ratio, charges = rows["permittivity_ratio"], f"{part}, charges on surfaces"
            axis.semilogx(ratio, rows[theirs], color=colour, label=f"{part}, finite elements")
            axis.semilogx(ratio, rows[ours], "o", color=colour, mfc="none", label=charges)
        axis.set_xticks([1, 3, 10], ["1", "3", "10"])
        top = 1.1 * float(table[[ours, theirs]].to_numpy().max())
        axis.set(xlabel="permittivity\nover air's (1)", ylabel=name, ylim=(0, top))
    for place, (kind, rows) in enumerate(far.groupby("far", sort=False)):
        style = {"marker": kit.figures.MARKERS[place + 1], "color": kit.figures.COLOURS[place + 2]}
        label = f"far boundary: {FAR_WORDS[str(kind)]}"
        box.semilogx(rows["reach"], rows["capacitance_elements"], label=label, **style)
    box.set_xticks(list(REACHES), [f"{reach:g}" for reach in REACHES])
    box.set(xlabel="its distance over\nthe slab's length (1)", ylabel=SHOWN[0][2])
    for axis, title in zip(axes, ("capacitance", "edge of the top", "half the slab"), strict=False):
        axis.set_title(title)
    box.set_title("far boundary of elements, ratio 3,\n100% covered")
    figure.suptitle("A slab of rubber in air, by two methods")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
