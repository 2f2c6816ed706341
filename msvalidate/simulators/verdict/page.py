"""The page of a simulator: what the terminal shows, a figure of causes, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from msvalidate.case.files import picture_files
from msvalidate.case.page import shown_pictures
from msvalidate.output.figures import COLOURS, add_shared_legend, new_figure
from msvalidate.output.rendering import render_template
from msvalidate.simulators.bodies.bodies import BodyRow
from msvalidate.simulators.verdict.judgement import Judgement
from msvalidate.simulators.verdict.sheet import Sheet

PAGE = "check.html"
CAUSES = {name: name for name in ("law", "resolution", "mass", "solver")} | {
    "not explained": "left"
}
"""What a bar is called -> the factor that it is."""


def sheet_files(
    name: str,
    found: Judgement,
    sheet: Sheet,
    settings: Mapping[str, str],
    origin: Mapping[str, str],
    *,
    plots: bool = True,
) -> dict[str, bytes]:
    """The page and its picture: name -> content.

    Parameters
    ----------
    name
        Of the adapter.
    settings
        That were handed on.
    origin
        Provenance.
    plots
        Whether the picture is drawn; there is none without bodies.
    """
    rows = [row for row in found.bodies if row.factors is not None]
    caption = "What each cause changes of the displacement of bodies at rest"
    drawn = {"causes": (caption, lambda: draw_causes(rows))} if plots and rows else {}
    content, pictures = picture_files(drawn)
    material = found.asked
    asked = {
        "material": f"E = {material.E:g} Pa, nu = {material.nu:g}, {material.density:g} kg/m³",
        **{f"setting {key}": value for key, value in settings.items()},
    }
    page = render_template(
        "simulator.html",
        title=name,
        sheet=sheet,
        pictures=shown_pictures(pictures),
        asked=asked,
        origin=origin,
    )
    return content | {PAGE: page.encode()}


def draw_causes(rows: list[BodyRow]) -> Figure:
    """Bars: by how many percent each cause makes the displacement of each body larger."""
    figure, (axis,) = new_figure(size=(6.2, 1.2 + 0.55 * len(rows)))
    place = np.arange(len(rows))[::-1]
    high = 0.8 / len(CAUSES)
    for number, (label, factor) in enumerate(CAUSES.items()):
        part = [100 * (getattr(row.factors, factor) - 1) for row in rows]
        at = place + 0.4 - high * (number + 0.5)
        axis.barh(at, part, height=high, color=COLOURS[number], label=label)
    axis.set_yticks(place, [f"{row.body}, {row.mesh}" for row in rows])
    axis.axvline(0, color="black", lw=0.8)
    axis.set_xlabel("change of the displacement (%)")
    add_shared_legend(figure, [axis], len(CAUSES))
    return figure
