# SPDX-License-Identifier: MIT
"""The two folders of an adapter: the request that it reads, the result that it leaves.

An adapter is a plain program, ``python ADAPTER.py CASE_DIR OUT_DIR``, that needs no more than this
file, NumPy and its simulator. ::

    def answer(request):
        if request.task == "motion":
            cannot("no positions can be given")
        iterations = setting(request, "iterations", 20)
        refuse_unknown(request)
        ...
        return {"simulator": "mine", "law": "linear", ...}, {"displacement": u}

    run(answer)

Numbers are SI. Rows of every array are the nodes of points.csv, counted from 0.
"""

import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np

FORMAT, USAGE, CANNOT = 1, 2, 77
ANSWERS = ("displacement", "position", "velocity", "force")
CORNERS = {"triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}


class Refusal(Exception):  # noqa: N818
    """A request that makes no sense: one line that names the thing, the value, the remedy."""


@dataclass
class Request:
    """What is asked, of n nodes in d dimensions.

    task "rest": displacement at rest under `load` and supports. "motion": `steps` steps of `dt`
    (s) from `start` at zero velocity, under gravity alone.
    """

    task: str
    name: str
    kind: str  # of cells: a key of CORNERS
    points: np.ndarray  # (n, d) m
    cells: np.ndarray  # (c, corners) nodes, in VTK order
    mass: np.ndarray  # (n,) kg, lumped
    force: np.ndarray  # (n, d) N, without weight
    held: np.ndarray  # (n, d) which components supports hold
    value: np.ndarray  # (n, d) m, and at which displacement
    gravity: np.ndarray  # (d,) m/s²
    material: SimpleNamespace  # E (Pa), nu, density (kg/m³), state, thickness (m)
    start: np.ndarray | None  # (n, d) m
    dt: float | None
    steps: int
    settings: dict[str, Any]
    springs: SimpleNamespace | None  # ends (m, 2), stiffness (m,) N/m, length at rest (m,) m

    def __post_init__(self) -> None:
        self.known: set[str] = set()

    @property
    def load(self) -> np.ndarray:
        """Forces and weight on the nodes, (n, d) N."""
        return self.force + self.mass[:, None] * self.gravity


def _table(path: Path, columns: int) -> np.ndarray:
    """Columns of numbers after the id, which counts rows from 0."""
    rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    if rows.size == 0 or rows.shape[1] != columns + 1:
        raise Refusal(f"{path.name}: {rows.shape} numbers; give an id and {columns} more a row")
    if not np.array_equal(rows[:, 0], np.arange(len(rows))):
        raise Refusal(f"{path.name}: ids do not count from 0; number the rows 0, 1, 2, ...")
    return rows[:, 1:]


def read_request(folder: str | Path) -> Request:
    """The request in a folder; raises `Refusal` or `OSError` where there is none."""
    folder = Path(folder)
    asked = json.loads((folder / "request.json").read_text(encoding="utf-8"))
    if asked.get("format") != FORMAT:
        raise Refusal(f"request.json: format {asked.get('format')}; this adapter reads {FORMAT}")
    d = asked["dimension"]
    nodal = _table(folder / "nodal.csv", 1 + 3 * d)
    springs = folder / "springs.csv"
    if springs.exists():
        a, b, stiffness, length = _table(springs, 4).T
        ends = np.c_[a, b].astype(int)
    return Request(
        **{name: asked[name] for name in ("task", "name", "dt", "steps", "settings")},
        kind=asked["cells"],
        points=_table(folder / "points.csv", d),
        cells=_table(folder / "cells.csv", CORNERS[asked["cells"]]).astype(int),
        mass=nodal[:, 0],
        force=nodal[:, 1 : 1 + d],
        held=nodal[:, 1 + d : 1 + 2 * d] != 0,
        value=nodal[:, 1 + 2 * d :],
        gravity=np.array(asked["gravity"], dtype=float),
        material=SimpleNamespace(**asked["material"]),
        start=_table(folder / "start.csv", d) if asked["task"] == "motion" else None,
        springs=SimpleNamespace(ends=ends, stiffness=stiffness, length=length)
        if springs.exists()
        else None,
    )


def cannot(reason: str) -> NoReturn:
    """End: the simulator cannot represent what is asked, which is no fault."""
    print(reason, file=sys.stderr)
    raise SystemExit(CANNOT)


def setting(request: Request, name: str, default: Any) -> Any:
    """A setting of its default's type, text ("0.5", "true") read as that; a tuple is a choice."""
    request.known.add(name)
    given = request.settings.get(name, default[0] if isinstance(default, tuple) else default)
    if isinstance(default, tuple):
        values = {str(value): value for value in default}
    elif isinstance(default, bool):
        values = {"True": True, "true": True, "False": False, "false": False}
    else:
        try:
            return type(default)(str(given))
        except ValueError:
            raise Refusal(f"setting {name}: {given!r}; give a value like {default!r}") from None
    if str(given) not in values:
        raise Refusal(f"setting {name}: {given!r}; choose from {', '.join(values)}")
    return values[str(given)]


def refuse_unknown(request: Request) -> None:
    """Raise `Refusal` for a setting that no call of `setting` has named; `run` calls it too."""
    for name in sorted(set(request.settings) - request.known):
        known = ", ".join(sorted(request.known)) or "none"
        raise Refusal(f"setting {name}: unknown; this adapter has {known}")


def write_result(folder: str | Path, about: dict[str, Any], **arrays: np.ndarray) -> None:
    """Leave result.npz and, last, result.json: a folder with both is complete."""
    folder = Path(folder)
    for name in set(arrays) - set(ANSWERS):
        raise Refusal(f"result {name}: unknown; give some of {', '.join(ANSWERS)}")
    text = json.dumps(about, indent=1, allow_nan=False)
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "result.npz", **{name: np.asarray(a, float) for name, a in arrays.items()})
    (folder / "result.json").write_text(text + "\n", encoding="utf-8")


def run(answer) -> None:
    """Read CASE_DIR, answer it by (about, arrays), write OUT_DIR with the seconds it took."""
    try:
        case, out = sys.argv[1:]
    except ValueError:
        raise SystemExit(f"usage: {sys.argv[0]} CASE_DIR OUT_DIR") from None
    try:
        request, begin = read_request(case), time.perf_counter()
        about, arrays = answer(request)
        refuse_unknown(request)
        write_result(out, {**about, "seconds": time.perf_counter() - begin}, **arrays)
    except (Refusal, OSError) as error:
        print(error, file=sys.stderr)
        raise SystemExit(USAGE) from None
