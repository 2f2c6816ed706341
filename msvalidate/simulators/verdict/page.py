"""The page of a simulator: what the terminal shows, a figure of causes, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from msvalidate.bench.judging.summary import TOLERANCE
from msvalidate.bench.output.body_drawing import SHOWN, network_drawing, overlay_drawings
from msvalidate.bench.output.figures import draw_solid, solid_axes
from msvalidate.bench.output.screen import MIXED, FirstScreen, Summary, render_screen
from msvalidate.case.report.figures import Drawn
from msvalidate.case.report.files import picture_files
from msvalidate.case.report.page import shown_pictures
from msvalidate.simulators.bodies.blocks import frozen_case
from msvalidate.simulators.bodies.bodies import BodyRow
from msvalidate.simulators.lattice.bodies import body_network
from msvalidate.simulators.verdict.judgement import Judgement
from msvalidate.simulators.verdict.sheet import Sheet, SheetTable
from msvalidate_check.text import percent

PAGE = "check.html"
LAW = "law at small strain"
"""Title of the table of moduli and ratios."""
CAPTIONS = {
    "gate": "Each question was passed, failed, or could not be answered.",
    "bodies at rest": "Error, and factor of the displacement by each cause. tet4_2: tet4 halved.",
    "cantilever": "Largest difference, relative to the largest displacement. The coarse cantilever "
    "differs from elasticity; a correct simulator agrees with the network of its springs.",
    LAW: "Modulus and ratio as requested, as documented, and as measured.",
}
"""Beginning of a table's title -> its caption."""


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
    moved = {row.body: row for row in found.bodies if row.move is not None}
    drawn: Drawn = {}
    if moved:
        caption = "Bodies are deformed as the simulator has them on its finest mesh, enlarged."
        drawn["bodies"] = (caption, lambda: draw_bodies([*moved.values()], found.asked.nu))
    errors = [row.error for row in found.bodies]
    if found.lattice is not None and found.lattice.bodies:
        body, springs = found.lattice.bodies[0], found.lattice.right
        errors += [each.errors["elasticity"] for each in found.lattice.bodies]
        network = body_network(body, springs.constants, springs.weight, body.request.mass)
        caption = "The cantilever of springs is deformed as the simulator has it, enlarged."
        drawn["cantilever"] = (
            caption,
            lambda: overlay_drawings([network_drawing(network, body.move)]),
        )
    content, pictures = picture_files(drawn if plots else {}, margin=None)
    badge, worst = (found.word, ""), max(errors, default=0.0)
    if worst > TOLERANCE:
        badge = MIXED, f"law {found.word}, coarse body {percent(worst)} from elasticity"
    material = found.asked
    request = {
        "material": f"E = {material.E:g} Pa, nu = {material.nu:g}, {material.density:g} kg/m³",
        **{f"setting {key}": value for key, value in settings.items()},
    }
    titles = [table.title.partition(":")[0] for table in sheet.tables]
    tables = list(map(_summary_of, titles, sheet.tables))
    screen = FirstScreen(
        f"msvalidate simulator: {sheet.who}",
        name,
        badge,
        f"{sheet.word[:1].upper()}{sheet.word[1:]}.",
        f"{sheet.next.removesuffix('.')}.",
        tables[-1] if tables else None,
        next(iter(shown_pictures(pictures)), None),
        (*sheet.causes, *(sheet.tables[-1].below if tables else ())),
        question=_solids(sheet),
    )
    page = render_screen(
        "simulator.html",
        screen,
        {title: title for title in titles[:-1]},
        tables=[*zip(titles, tables, (table.below for table in sheet.tables), strict=True)][:-1],
        notes=sheet.notes,
        request=request,
        origin=origin,
    )
    return content | {PAGE: page.encode()}


def _solids(sheet: Sheet) -> str:
    """Question of the page, with modulus and ratio as requested and as measured."""
    question = "Which elastic solid does this simulator represent?"
    for table in sheet.tables:
        if table.title.startswith(LAW):
            texts = [f"E = {row[1]} Pa, nu = {row[2]}" for row in (table.rows[0], table.rows[-1])]
            return f"{question} Requested: {texts[0]}. Result: {texts[1]}."
    return question


def _summary_of(title: str, table: SheetTable) -> Summary:
    """Table of a page; the name of a frozen case is left to the record."""
    shown = [place for place, head in enumerate(table.columns) if head != "case"]
    heads, *rows = ([row[place] for place in shown] for row in (table.columns, *table.rows))
    return Summary(CAPTIONS[title], heads, rows, [False] * len(shown))


def draw_bodies(rows: list[BodyRow], nu: float) -> Figure:
    """Deformed surfaces as the simulator has them, coloured by displacement, over the bodies."""
    figure, axes = solid_axes(len(rows), (4.4, 2.4), rows=len(rows))
    for axis, row in zip(axes, rows, strict=True):
        points = frozen_case(row.case, row.mesh, nu).points
        # y is drawn upwards, as the loads of these bodies have it
        x, move = (np.asarray(each)[:, [0, 2, 1]] for each in (points, row.move))
        size = np.linalg.norm(move, axis=1)
        times = SHOWN * float(np.ptp(x, axis=0).max() / (size.max() or 1.0))
        draw_solid(axis, x, x + times * move, size, Normalize(0.0, size.max()))
        axis.set(ylabel="z (m)", zlabel="y (m)", title=f"{row.body}, enlarged {times:.3g} times")
    return figure
