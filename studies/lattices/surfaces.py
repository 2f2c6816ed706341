"""The modulus by direction, drawn from the table `tensors`: curves and surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LightSource, Normalize
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.constants.directions import directional_modulus

ROUND = 181
"""Directions of a curve; of a surface as many round, and half as many up and down."""
FINE = 61
PANELS = 4
LIGHT = LightSource(azdeg=180, altdeg=60)


def tensors(tables: kit.Tables, axes: int) -> Iterator[tuple[str, str, float | str, kit.Array]]:
    """Lattice, rule, Zener's ratio and Voigt tensor of every solid that resists every strain."""
    place = {f"{'xyz'[a]}{'xyz'[b]}": n for n, (a, b) in enumerate(kit.VOIGT[axes])}
    table, solids = tables["tensors"], tables["solids"]
    for row in solids[(solids["axes"] == axes)].to_dict("records"):
        if row["strains"] != "every strain":
            continue
        mine = table[(table["lattice"] == row["lattice"]) & (table["rule"] == row["rule"])]
        C = np.zeros((len(place), len(place)))
        for entry in mine.to_dict("records"):
            i, j = place[entry["row"]], place[entry["column"]]
            C[i, j] = C[j, i] = entry["numerical"]
        yield str(row["lattice"]), str(row["rule"]), row["A"], C


def told(zener: float | str) -> str:
    """Zener's ratio in a label, or that there is none."""
    return f"A = {zener:.3g}" if isinstance(zener, float) else "no A"


def draw_plane(tables: kit.Tables) -> Figure:
    """E by direction over E along x, a curve for each plane lattice."""
    axis: Any  # a polar one
    figure, (axis,) = kit.figures.new_figure(size=(5.0, 4.4), subplot_kw={"projection": "polar"})
    angle = np.linspace(0, 2 * np.pi, ROUND)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    dashes = ["-", "--", "-.", ":"]
    for n, (lattice, rule, zener, C) in enumerate(tensors(tables, 2)):
        modulus = directional_modulus(C, normal)
        colour = kit.figures.COLOURS[n % len(kit.figures.COLOURS)]
        label = f"{lattice}, {rule}: {told(zener)}"
        style = dashes[n % len(dashes)]
        # Later ones narrower: several are the same circle.
        width = max(1.2, 4.0 - 0.6 * n)
        axis.plot(angle, modulus / modulus[0], style, color=colour, lw=width, label=label)
    axis.set_ylim(0)
    axis.set_xlabel("direction of the pull to the x axis (degrees)")
    axis.set_ylabel("modulus over that along x (1)", labelpad=28)
    axis.set_rlabel_position(100)
    figure.suptitle("Plane lattices: Young's modulus by direction")
    kit.figures.add_shared_legend(figure, [axis], columns=1)
    return figure


def draw_space(tables: kit.Tables) -> Figure:
    """E by direction over E along x, a surface for each solid, on one scale of colour."""
    drawn = list(tensors(tables, 3))
    theta, phi = np.meshgrid(np.linspace(0, np.pi, FINE // 2 + 1), np.linspace(0, 2 * np.pi, FINE))
    normal = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    radius = []
    for _, _, _, C in drawn:
        along_x = directional_modulus(C, np.array([[1.0, 0.0, 0.0]]))[0]
        radius.append(directional_modulus(C, normal.reshape(-1, 3)).reshape(theta.shape) / along_x)
    scale = Normalize(min(r.min() for r in radius), max(r.max() for r in radius))
    columns = min(PANELS, len(drawn))
    rows = -(-len(drawn) // columns)
    figure, axes = kit.figures.new_figure(
        columns, rows, size=(1.8, 2.2), subplot_kw={"projection": "3d"}
    )
    colours = colormaps["cividis"]
    axis: Any  # of three axes, which the type of flat ones does not know
    for axis, (lattice, rule, zener, _), r in zip(axes, drawn, radius, strict=False):
        x, y, z = np.moveaxis(r[..., None] * normal, -1, 0)
        axis.plot_surface(
            x,
            y,
            z,
            facecolors=colours(scale(r)),
            rstride=1,
            cstride=1,
            linewidth=0,
            antialiased=False,
            lightsource=LIGHT,
            rasterized=True,
        )
        reach = 1.05 * float(r.max())
        axis.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
        axis.set_box_aspect((1, 1, 1), zoom=0.95)
        axis.set_title(f"{lattice}, {rule}\n{told(zener)}", fontsize=9)
        axis.set(xlabel="x", ylabel="y", zlabel="z", xticks=[], yticks=[], zticks=[])
        axis.xaxis.labelpad = axis.yaxis.labelpad = axis.zaxis.labelpad = -14
    for axis in axes[len(drawn) :]:
        figure.delaxes(axis)
    bar = figure.colorbar(ScalarMappable(scale, colours), ax=axes, shrink=0.6, pad=0.02)
    figure.suptitle("Solid lattices: Young's modulus by direction")
    bar.set_label("modulus over that along x (1)")
    return figure


FIGURES = {2: ("moduli_plane", draw_plane), 3: ("moduli_space", draw_space)}
"""By the number of axes."""
