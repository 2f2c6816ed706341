"""The command line: `msvalidate-check list`, `mesh` and `field`.

Exit codes: 0 the field agrees, 1 it does not or that is not known, 2 bad input: a file that cannot
be read, or numbers that cannot be judged; 3 a fault of the program itself, no verdict.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from msvalidate_check.case_set import ElasticCase, case_facts, case_names, elastic_case
from msvalidate_check.checking import ACCURACY, BAND, check
from msvalidate_check.errors import CheckError
from msvalidate_check.exchange import write
from msvalidate_check.fields import read_field

AGREED, MISSED, BAD_INPUT, FAULT = 0, 1, 2, 3


def run(arguments: Sequence[str] | None = None) -> int:
    """Read the command line and do what it asks; the exit code."""
    parser = _parser()
    given = parser.parse_args(arguments)
    try:
        return int(given.act(given))
    except CheckError as error:
        print(f"msvalidate-check: {error}", file=sys.stderr)  # noqa: T201
        return BAD_INPUT
    except BrokenPipeError:
        return AGREED
    except Exception as error:  # noqa: BLE001  no traceback, whose code would be that of a verdict
        said = " ".join(f"{type(error).__name__}: {error}".split())
        print(f"msvalidate-check: a fault of the program itself: {said}", file=sys.stderr)  # noqa: T201
        return FAULT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="msvalidate-check",
        description="How far displacements are from elasticity, on cases whose answer is known.",
    )
    acts = parser.add_subparsers(required=True, metavar="ACT")
    every = acts.add_parser("list", help="the cases, their meshes and Poisson's ratios")
    every.set_defaults(act=_list)
    mesh = acts.add_parser("mesh", help="write a case's mesh, forces and supports as CSV")
    _add_case(mesh)
    mesh.add_argument("folder", type=Path, help="to write nodes.csv and cells.csv to")
    mesh.set_defaults(act=_write_mesh)
    field = acts.add_parser("field", help="judge displacements in a file")
    _add_case(field)
    field.add_argument(
        "file",
        type=Path,
        help=".csv (ux, uy, uz, and x, y, z or id) or .npz (displacement, and points or id)",
    )
    field.add_argument("--band", type=float, default=BAND, help="that agrees (default %(default)s)")
    field.add_argument(
        "--at-rest", type=float, help="how much they may still change, over the largest"
    )
    field.add_argument(
        "--accuracy",
        type=float,
        default=ACCURACY,
        help="of the displacements, over the largest (default %(default)s)",
    )
    field.set_defaults(act=_judge)
    return parser


def _add_case(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", help='such as "block_pull" or "cook_plane_strain"; see list')
    parser.add_argument(
        "--nu", type=float, default=0.3, help="Poisson's ratio (default %(default)s)"
    )
    parser.add_argument("--mesh", help="such as tri3, quad4, tet4, hex8, tet4_2")
    parser.add_argument("--state", help="plane_stress, plane_strain or space")


def _case(given: Any) -> ElasticCase:
    return elastic_case(given.case, given.nu, given.mesh, given.state)


def _list(_: Any) -> int:
    rows = []
    for name in case_names():
        facts = case_facts(name)
        ratios = ", ".join(f"{nu:g}" for nu in facts["ratios"])
        rows.append((name, " ".join(facts["meshes"]), ratios))
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    for name, meshes, ratios in rows:
        print(f"{name:{widths[0]}}  {meshes:{widths[1]}}  nu = {ratios}")  # noqa: T201
    return AGREED


def _write_mesh(given: Any) -> int:
    case = _case(given)
    axes = "xyz"[: case.points.shape[1]]
    head = ["id", *axes, "mass", *(f"f{a}" for a in axes)]
    head += [*(f"held_{a}" for a in axes), *(f"value_{a}" for a in axes)]
    nodes = [
        [str(i), *_texts(x), *_texts([m]), *_texts(f), *(str(int(h)) for h in held), *_texts(value)]
        for i, (x, m, f, held, value) in enumerate(
            zip(case.points, case.mass, case.force, case.held, case.value, strict=True)
        )
    ]
    cells = [
        [str(i), *map(str, cell), *_texts([E])]
        for i, (cell, E) in enumerate(zip(case.cells, case.modulus, strict=True))
    ]
    corners = ["id", *(f"n{k}" for k in range(case.cells.shape[1])), "E"]
    files = {
        name: "".join(f"{','.join(row)}\n" for row in rows).encode()
        for name, rows in (("nodes.csv", [head, *nodes]), ("cells.csv", [corners, *cells]))
    }
    try:
        write(given.folder, files)
    except OSError as error:
        raise CheckError(f"{given.folder}: {error.strerror}; name a folder to write to") from error
    E = " and ".join(f"{E:g}" for E in np.unique(case.modulus))
    law = f"E = {E} Pa, nu = {case.nu:g}, density {case.density:g} kg/m3"
    print(f"{case.name}, {case.mesh}: {law}, thickness {case.thickness:g} m")  # noqa: T201
    return AGREED


def _texts(values: Sequence[float] | np.ndarray) -> list[str]:
    return [repr(float(value)) for value in values]


def _judge(given: Any) -> int:
    case = _case(given)
    points, move, rest = read_field(given.file)
    rest = given.at_rest if given.at_rest is not None else rest
    verdict = check(case, points, move, band=given.band, at_rest=rest, accuracy=given.accuracy)
    print(verdict)  # noqa: T201
    return AGREED if verdict else MISSED
