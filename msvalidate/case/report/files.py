"""Output folder of a case: page, tables, pictures, fields and verdict.

It is written as a whole or not at all.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from matplotlib.figure import Figure

from msvalidate.bench.output.stored import draw_files
from msvalidate.bench.output.vtu import vtu_bytes
from msvalidate.case.compare.comparison import Comparison
from msvalidate.case.judge.judgement import Judged
from msvalidate.case.report.figures import show_in_units
from msvalidate.problem import (
    AXES,
    SHAPES,
    VOIGT,
    Array,
    Isotropic,
    Problem,
    ProblemError,
    materials_at,
    materials_of_cells,
)
from msvalidate.problem.checks import format_value
from msvalidate.problem.progress import report_step
from msvalidate_check import exchange
from reference_fem.body import Solution

MARK = "case.json"
"""The file that tells a folder of results of a case from other people's."""
LONGEST_FOLDER = 80
MARGIN = 0.25
"""White margin (inches) of a picture: 40 pixels."""


def folder_name(stem: str) -> str:
    """A folder's name from a file's: letters, digits and dashes alone."""
    found = re.sub(r"[^A-Za-z0-9_]+", "-", stem).strip("-")[:LONGEST_FOLDER]
    return found or "case"


def refuse_foreign(folder: Path, whose: str) -> None:
    """Raise `ProblemError` where a folder holds what no case left there, or another one did.

    `whose` results it is for: the name of their file, or files.
    """
    if folder.exists() and not folder.is_dir():
        raise ProblemError(f"folder {folder} is a file; name another folder")
    if not folder.is_dir():
        return
    try:
        mark = json.loads((folder / MARK).read_text(encoding="utf-8"))
        own, of = set(mark["files"]), mark.get("of", whose)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        own, of = set(), whose
    # A link would be written through; what a killed run staged is removed by the next run.
    others = sorted(
        path.name
        for path in folder.rglob("*")
        if path.is_symlink() or (path.parent == folder and path.name not in own)
        if not path.name.startswith(exchange.STAGED)
    )
    if others:
        raise ProblemError(
            f"folder {folder} holds {format_value(others[0])}, which no case left there; name "
            "another folder, or move it away"
        )
    if of != whose:
        raise ProblemError(
            f"folder {folder} holds results of {format_value(of)}; name another folder, or move it "
            "away"
        )


def claim(folder: Path, names: Sequence[str], whose: str) -> None:
    """Make a folder for these files, whoever writes there meanwhile, and mark it."""
    refuse_foreign(folder, whose)
    folder.mkdir(parents=True, exist_ok=True)
    mark = {"files": [*names, MARK], "of": whose}
    exchange.replace_file(folder / MARK, partial(json_bytes, mark))


def publish(folder: Path, files: exchange.Files, whose: str) -> None:
    """Put the files in the folder's place in one step; what was there stays until then."""
    refuse_foreign(folder, whose)
    names = sorted([*files, MARK])
    exchange.replace_one(folder, {**files, MARK: json_bytes({"files": names, "of": whose})})


def picture_files(
    pictures: Mapping[str, tuple[str, Callable[[], Figure]]],
    length: str = "m",
    margin: float | None = MARGIN,
) -> tuple[dict[str, bytes], dict[str, tuple[str, bytes]]]:
    """PNG and SVG of each picture, and name -> caption and SVG for the page.

    Axes are in the unit `length`, a key of `case.file.units.LENGTH`, and pictures are trimmed to a
    margin (inches) if there is one.
    """

    def in_units(draw: Callable[[], Figure]) -> Figure:
        figure = draw()
        show_in_units(figure, length)
        return figure

    files: dict[str, bytes] = {}
    shown = {}
    for name, (caption, draw) in pictures.items():
        report_step("%s", name)
        made = draw_files(name, caption, partial(in_units, draw), margin=margin)
        files |= made
        shown[name] = (caption, made[f"{name}.svg"])
    return files, shown


def field_files(found: Comparison) -> dict[str, bytes]:
    """elements.vtu with displacement and stress; compared.vtu with the compared points."""
    solution, problem = found.reference.finest, found.case.problem
    body = solution.body
    places = body.points[body.cells]
    first_order = "" if found.reference.large is None else "_to_first_order"
    fields = {"displacement_elements": solution.displacement, **stress_fields(solution, problem)}
    elements = vtu_bytes(
        body.points,
        {body.element.shape: body.cells},
        {f"{name}{first_order}": each for name, each in fields.items()},
        {"material": materials_of_cells(problem, places, SHAPES[body.element.shape])},
    )
    compared = compared_file(found.points, "springs", found.displacement, found)
    return {"elements.vtu": elements, "compared.vtu": compared}


def stress_fields(solution: Solution, problem: Problem) -> dict[str, Array]:
    """Components of stress and von Mises stress at the nodes.

    They are fields (n,) in Pa. Where cells meet, each is the mean over them. Plane strain has
    σzz = nu·(σxx + σyy).
    """
    points, dim = solution.body.points, solution.body.dim
    names = [f"stress_{AXES[a]}{AXES[b]}" for a, b in VOIGT[dim]]
    fields = dict(zip(names, solution.stress(points).T, strict=True))
    squares = sum(fields[name] ** 2 for name in names[dim:])
    if dim == 2:
        laws = [each for each in problem.materials if isinstance(each, Isotropic)]
        nu = np.array([each.nu * (each.state == "plane_strain") for each in laws])
        sides = fields["stress_xx"] + fields["stress_yy"]
        fields["stress_zz"] = nu[materials_at(problem, points)] * sides
    x, y, z = (fields[f"stress_{axis}{axis}"] for axis in AXES)
    mises = np.sqrt(((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) / 2 + 3 * squares)
    return fields | {"von_mises": mises}


def compared_file(
    places: Array, whose: str, displacement: Array, found: Comparison | Judged
) -> bytes:
    """A .vtu file with a vertex a compared point: displacements (m) and their difference (1)."""
    fields = {
        f"displacement_{whose}": displacement,
        "displacement_elements": found.reference.displacement.value,
        "difference": found.relative,
    }
    return vtu_bytes(places, {"vertex": np.arange(len(places))[:, None]}, fields)


def json_bytes(content: Any) -> bytes:
    """JSON with a line a key; numbers that are none become null."""
    return msgspec.json.format(msgspec.json.encode(content, enc_hook=_plain)) + b"\n"


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else format_value(value)
