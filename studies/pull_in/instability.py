"""Instability: at which voltage, and in which mode, does a slab lose its stability on each mesh?

Question   The lowest eigenvalue of K_mech - K_elec falls to zero below the pull-in of the uniform
           slab. In which mode, and what of it is the slab's, what the mesh's?
Candidate  A way to rest at a voltage and its softest motions, followed as `branches` has it.
Reference  Waves of an infinite slab of the same lattice (`infinite`), which has no edges.
Expected   At an edge the charge grows as the inverse root of the distance: a point there is pulled
           with a force that does not fall with the cells, and softened by it over a cell's size a.
           The flat slab gives way at a voltage like √a, which goes to nothing, less a part of the
           order of √(a/h). Inside, waves about as long as the slab is high soften before the slab
           as a whole. As waves shorten beside h their voltage falls to that of a half space like
           exp(-2kh), while cells stiffen them by the order of (ka)². So the voltage settles, and
           the wavelength is where these two meet: h/λ grows as ln(h/a)/2π or so, without end.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform

from . import branches, infinite, instability_drawing
from .branches import FOLLOWED, Branch, closed
from .slab import HEIGHT, LENGTH, PULL_IN, REACH
from .way import PullInSolver

QUICK_LAYERS, LAYERS = (3, 4, 6), (5, 10, 16)
QUICK_FINER, FINER = (4, 8, 16), (5, 10, 16, 32, 64, 128)
"""Layers of infinite slabs."""
SHOWN = 1
"""Which of the meshes' modes are kept and drawn."""
CHANGED = 0.1
"""Part by which a number may differ between the coarsest mesh and the finest and not be the
mesh's."""
WAVED = (
    "critical_infinite",
    "mode_wavelength_over_h",
    "wavelength_infinite",
    "wavelength_over_spacing",
)
"""Columns of a mode inside the slab; there are none of one at its edges."""
WAVES = 48
"""Wavelengths among which an infinite slab's softest is looked for, before it is refined."""
RULES = (
    kit.Rule(
        "lowest eigenvalue at the critical voltage over that at no voltage", 0.05, "1",
        "where equilibria end it falls as the root of what is missing of the voltage, √1e-6, from "
        "what the edge alone had, ten times that of the whole; inside in proportion to it, 1e-4, "
        "fifty times as steep at the end as on the whole",
        table="instability", value="left",
    ),
)  # fmt: skip


ROUNDING = {
    # Brackets of voltages, 1e-4 of them, and what an eigenvalue and a mode are known to there.
    **dict.fromkeys(("critical_over_pull_in", "voltage_over_pull_in", "voltage"), 1e-3),
    **dict.fromkeys(("left", "softest", "softest_infinite", "edge_moved_over_spacing"), 1e-2),
    **dict.fromkeys(("x_m", "y_m", "at_edge"), 0.05),
    **dict.fromkeys(("mode_wavelength_over_h", "wavelength_over_spacing"), 0.05),
    # The grid of wavelengths, where the voltage is flat.
    "wavelength_infinite": 0.02,
}


def run(candidate: PullInSolver, setting: kit.Setting) -> kit.Evidence:
    """Follow every branch on every mesh."""
    layers = QUICK_LAYERS if setting.quick else LAYERS
    cases = [(branch, count) for branch in FOLLOWED for count in layers]
    found = setting.sweep(partial(follow_branch, candidate), cases, "instabilities")
    table = label_mesh_dependence(pd.DataFrame([row for row, _, _ in found]))
    kept = [shape for (_, _, shape), (_, count) in zip(found, cases, strict=True)
            if count == layers[SHOWN]]  # fmt: skip
    finer = QUICK_FINER if setting.quick else FINER
    flat, inside = (table[table["branch"] == branch] for branch in ("edge, flat", "inside"))
    power = kit.fitted_power(flat["spacing_m"], flat["critical_over_pull_in"])
    own = (
        kit.Tolerance(
            "exponent in the spacing of the voltage at which the flat slab's edge gives way",
            0.1, "1",
            "√a·(1 - b·√(a/h)) has the exponent 1/2 - b·√(a/h)/2 or so: 0.09 less on cells of a "
            "third of the height, with the b = 0.3 that the three cells themselves give",
            observed=kit.Observed(power.exponent, 0.5),
        ),
        kit.Tolerance(
            "critical voltage inside over that of an infinite slab with the same cells, from 1",
            0.01, "1",
            "the outer field of the finite slab takes 1 % off the pull, half of that off the "
            "voltage; held ends stiffen a wave by the square of its length over their distance",
            layer="agreement",
            observed=kit.farthest_value(
                inside["critical_over_pull_in"] / inside["critical_infinite"].astype(float), 1.0
            ),
        ),
        kit.Tolerance(
            "mode inside: part of its square at the electrode's edges", 0.0, "1",
            "points there are held: a mode has no component there at all",
            observed=kit.farthest_value(inside["at_edge"], 0.0),
        ),
    )  # fmt: skip
    limits = pd.DataFrame([softest_wave(count) for count in finer])
    return kit.Evidence(
        tables={
            "instability": table,
            "softest": pd.DataFrame([row for _, rows, _ in found for row in rows]),
            "waves": pd.concat([spectrum(count) for count in finer], ignore_index=True),
            "waves_softest": limits,
        },
        tolerances=(*RULES, *own),
        drawn={"mode_shapes": pd.concat(kept, ignore_index=True)},
        figures={
            "softest": instability_drawing.softest,
            "modes": instability_drawing.modes,
            "waves": instability_drawing.waves,
        },
        columns=kit.columns(__file__),
        findings=findings(table, limits),
    )


def follow_branch(
    way: PullInSolver, case: tuple[str, int]
) -> tuple[dict[str, object], list[dict[str, object]], pd.DataFrame]:
    """A branch on a mesh: its row, eigenvalues on the way, and the mode at its end."""
    name, layers = case
    branch = FOLLOWED[name](way, layers)
    wave = wave_of_film(branch, layers) if name == "inside" else dict.fromkeys(WAVED, "none")
    last = branch.last
    edge_moved = np.linalg.norm(last.displacement[last.actuator.electrodes[0][-1]])
    row = {
        "branch": name,
        "layers": layers,
        "spacing_m": HEIGHT / layers,
        "critical_over_pull_in": last.voltage / PULL_IN.voltage,
        **wave,
        "edge_moved_over_spacing": float(edge_moved) * layers / HEIGHT,
        "at_edge": branches.at_edge(last, branch.mode),
        "left": branch.seen[-1][1] / branch.seen[0][1],
    }
    rows: list[dict[str, object]] = [
        {
            "branch": name,
            "layers": layers,
            "voltage": volts,
            "voltage_over_pull_in": volts / PULL_IN.voltage,
            "softest": value,
            "softest_infinite": infinite_softest(layers, volts) if name == "inside" else "none",
        }
        for volts, value in branch.seen
    ]
    return row, rows, shape(name, layers, branch)


def wave_of_film(branch: Branch, layers: int) -> dict[str, object]:
    """A mode's wavelength beside that of an infinite slab."""
    length, soft = branches.wavelength(branch.last, branch.mode), softest_wave(layers)
    values = (
        soft["critical_infinite"],
        length / HEIGHT,
        soft["wavelength_infinite"],
        length * layers / HEIGHT,
    )
    return dict(zip(WAVED, values, strict=True))


def infinite_softest(layers: int, volts: float) -> float:
    """Lowest eigenvalue (N/m) over waves that fit between the ends, at a voltage (V)."""
    q = 2 * np.pi / wavelengths(layers)
    return float(infinite.softest_wave(min(closed(volts), 1 - 1e-12), layers, q).min())


def wavelengths(layers: int) -> kit.Array:
    """From twice the spacing to twice what lies between the held ends (m)."""
    return np.geomspace(2 * HEIGHT / layers, 2 * (LENGTH - 2 * REACH), WAVES)


def shape(name: str, layers: int, branch: Branch) -> pd.DataFrame:
    """A mode over the points of the network, its largest component 1."""
    x, y = branch.last.position.T
    u, v = (branch.mode / np.abs(branch.mode).max()).T
    return pd.DataFrame(
        {"branch": name, "layers": layers, "x_m": x, "y_m": y, "mode_x_here": u, "mode_y_here": v}
    )


def spectrum(layers: int) -> pd.DataFrame:
    """Voltage at which each wave of an infinite slab costs nothing."""
    lengths = wavelengths(layers)[::2]
    return pd.DataFrame(
        {
            "layers": layers,
            "wavelength_over_h": lengths / HEIGHT,
            "critical_over_pull_in": critical(layers, lengths),
        }
    )


def critical(layers: int, lengths: kit.Array) -> kit.Array:
    """Critical voltage over pull-in (w,) of waves of these lengths (m) of an infinite slab."""
    parts = infinite.thresholds(layers, lengths)
    return np.array([uniform.voltage(part, height=HEIGHT) for part in parts]) / PULL_IN.voltage


def softest_wave(layers: int) -> dict[str, float]:
    """The wave of an infinite slab that goes first, and at which voltage: by a parabola."""
    lengths = wavelengths(layers)
    volts = critical(layers, lengths)
    at = int(np.clip(volts.argmin(), 1, len(volts) - 2))
    near = np.log(lengths[at - 1 : at + 2])
    a, b, _ = np.polyfit(near - near[1], volts[at - 1 : at + 2], 2)
    best = float(np.exp(near[1] - b / (2 * a)))
    return {
        "layers": layers,
        "spacing_m": HEIGHT / layers,
        "critical_infinite": float(critical(layers, np.array([best]))[0]),
        "wavelength_infinite": best / HEIGHT,
        "wavelength_over_spacing": best * layers / HEIGHT,
    }


def label_mesh_dependence(table: pd.DataFrame) -> pd.DataFrame:
    """The table with a column that says what is the mesh's."""
    names = {"voltage": "critical_over_pull_in", "wavelength": "mode_wavelength_over_h"}
    said = {}
    for branch, own in table.groupby("branch", sort=False):
        changed = [name for name, column in names.items() if relative_change(own[column]) > CHANGED]
        said[branch] = " and ".join(changed) or "nothing"
    return table.assign(mesh_dependent=table["branch"].map(said))


def relative_change(values: pd.Series) -> float:
    """Part by which the last differs from the first; 0 where there are words."""
    first, last = values.iloc[0], values.iloc[-1]
    return 0.0 if isinstance(first, str) else abs(float(last) / float(first) - 1)


def findings(table: pd.DataFrame, limits: pd.DataFrame) -> tuple[str, ...]:
    """What goes first, and what of it is the mesh's."""
    flat, edge, inside = (table[table["branch"] == branch] for branch in FOLLOWED)
    powers = [
        kit.fitted_power(own["spacing_m"], own["critical_over_pull_in"]).exponent
        for own in (flat, edge)
    ]
    finest, coarsest = limits.iloc[-1], limits.iloc[0]
    at_edges = (
        f"The electrode's edge goes first, at {list_numbers(edge['critical_over_pull_in'])} of the "
        f"uniform pull-in voltage with {list_numbers(edge['layers'])} layers. It is the mesh's: on "
        f"the "
        f"flat slab the voltage goes as the spacing to the power {powers[0]:.3f} (1/2 as cells "
        f"shrink); followed, the edge moves by {list_numbers(edge['edge_moved_over_spacing'])} "
        f"spacings "
        f"before it gives way, and the power is {powers[1]:.3f}."
    )
    within = (
        f"Inside, the slab goes at {list_numbers(inside['critical_over_pull_in'])} of it "
        f"({list_numbers(inside['critical_infinite'])} in an infinite slab of these cells), in "
        f"waves of "
        f"{list_numbers(inside['mode_wavelength_over_h'])} heights. Mesh-dependent: "
        f"{inside['mesh_dependent'].iloc[0]}."
    )
    without_end = (
        f"Infinite slabs of {coarsest['layers']:g} to {finest['layers']:g} layers go at "
        f"{coarsest['critical_infinite']:.4f} to {finest['critical_infinite']:.4f}, in waves of "
        f"{coarsest['wavelength_infinite']:.3g} to {finest['wavelength_infinite']:.3g} heights, "
        f"{coarsest['wavelength_over_spacing']:.3g} to {finest['wavelength_over_spacing']:.3g} "
        "spacings: the voltage settles, the wavelength does not."
    )
    return at_edges, within, without_end


def list_numbers(values: pd.Series) -> str:
    """Numbers in a sentence."""
    return ", ".join(f"{float(value):.3g}" for value in values)
