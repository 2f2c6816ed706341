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
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np

FORMAT, USAGE, CANNOT = 1, 2, 77
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
    known: set[str] = field(default_factory=set)  # settings, by `setting`

    @property
    def load(self) -> np.ndarray:
        """Forces and weight on the nodes, (n, d) N."""
        return self.force + self.mass[:, None] * self.gravity


def _table(path: Path, columns: int) -> np.ndarray:
    rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    if rows.shape[1] != columns + 1 or not np.array_equal(rows[:, 0], np.arange(len(rows))):
        raise Refusal(f"{path.name}: give ids 0, 1, 2, ... and {columns} numbers more a row")
    return rows[:, 1:]


def read_request(folder: str | Path) -> Request:
    """The request in a folder; raises `Refusal` where there is none."""
    try:
        return _request(Path(folder))
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise Refusal(f"{folder}: {error!r}; give the folder of a request") from None


def _request(folder: Path) -> Request:
    asked = json.loads((folder / "request.json").read_text(encoding="utf-8"))
    if asked["format"] != FORMAT:
        raise Refusal(f"request.json: format {asked['format']}; this adapter reads {FORMAT}")
    d = asked["dimension"]
    nodal = _table(folder / "nodal.csv", 1 + 3 * d)
    mass, force, held, value = np.split(nodal, [1, 1 + d, 1 + 2 * d], axis=1)
    asked["springs"] = None
    if (folder / "springs.csv").exists():
        a, b, k, length = _table(folder / "springs.csv", 4).T
        asked["springs"] = SimpleNamespace(ends=np.c_[a, b].astype(int), stiffness=k, length=length)
    return Request(
        **{name: asked[name] for name in ("task", "name", "dt", "steps", "settings", "springs")},
        mass=mass[:, 0],
        force=force,
        held=held != 0,
        value=value,
        kind=asked["cells"],
        points=_table(folder / "points.csv", d),
        cells=_table(folder / "cells.csv", CORNERS[asked["cells"]]).astype(int),
        gravity=np.array(asked["gravity"], dtype=float),
        material=SimpleNamespace(**asked["material"]),
        start=_table(folder / "start.csv", d) if asked["task"] == "motion" else None,
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
    for name in set(request.settings) - request.known:
        raise Refusal(f"setting {name}: unknown; give some of {sorted(request.known)}")


def write_result(folder: str | Path, about: dict[str, Any], **arrays: np.ndarray) -> None:
    """Leave result.npz (displacement | position, velocity | force) and, last, result.json."""
    folder, text = Path(folder), json.dumps(about, indent=1, allow_nan=False)
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "result.npz", **{name: np.asarray(a, float) for name, a in arrays.items()})
    (folder / "result.json").write_text(text + "\n", encoding="utf-8")


def run(answer) -> None:
    """Read CASE_DIR, answer it by (about, arrays), write OUT_DIR with the seconds it took."""
    if len(sys.argv) != 3:
        print(f"usage: {sys.argv[0]} CASE_DIR OUT_DIR", file=sys.stderr)
        raise SystemExit(USAGE)
    try:
        request, begin = read_request(sys.argv[1]), time.perf_counter()
        about, arrays = answer(request)
        refuse_unknown(request)
        write_result(sys.argv[2], {**about, "seconds": time.perf_counter() - begin}, **arrays)
    except Refusal as error:
        print(error, file=sys.stderr)
        raise SystemExit(USAGE) from None
