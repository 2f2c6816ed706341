"""The frozen set: elastic bodies, meshes of them, and elasticity's displacements at their points.

The set is data in one file beside this one, whose checksum is in `msvalidate_check.frozen`: a file
that was changed is refused. It is version 2: the same in plain text, with how it was made and what
confirms it, are the folders ``cases/v1`` and ``cases/v2`` of the project, of which a file of the
second replaces that of the first, and ``cases/v2/ERRATA.md`` says why.
"""

from __future__ import annotations

import difflib
import hashlib
import io
import json
from dataclasses import dataclass
from functools import cache
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from msvalidate_check.diagnosis import Driven
from msvalidate_check.errors import CheckError
from msvalidate_check.frozen import DIGESTS

Array = np.ndarray
VERSION = 2
"""Of the set."""
HERE = Path(__file__).resolve().parent
PLANE, SPACE = ("tri3", "quad4"), ("tet4", "hex8")
STATES = ("plane_stress", "plane_strain", "space")
SAME_RATIO = 1e-9
CUBIC = 5e-4
"""Of the largest displacement, to which elasticity is known between two of the set's ratios."""


@dataclass(frozen=True, eq=False)
class ElasticCase:
    """A body on one mesh, how it is held and loaded, and what elasticity says of it.

    Parameters
    ----------
    name, state, mesh
        Of the case, "plane_stress", "plane_strain" or "space", and of the mesh.
    E, nu, density, thickness
        In Pa, 1, kg/m³ and m; the thickness in space is 1. Poisson's ratio and the density hold in
        the whole body; E too, but in bodies of two materials, whose `modulus` tells it.
    points
        (n, d) nodes of the mesh, in m.
    cells
        (c, k) their corners, in VTK's order.
    modulus
        (c,) Young's modulus of each cell in Pa: E, but for "bimaterial_bar".
    mass
        (n,) lumped masses in kg.
    force
        (n, d) outer forces on the nodes in N, gravity among them.
    held, value
        (n, d) which components are prescribed, and to what (m).
    named
        (p,) nodes at which elasticity is known: the first p.
    wanted
        (p, d) elasticity's displacement there, in m.
    uncertainty
        Of it, over the largest.
    quantities
        Name -> elasticity's value and its uncertainty: "reaction 1" (d,) in N of the first support,
        "strain energy" (1,) in J, "mean stress" in Pa: xx, yy, xy or xx, yy, zz, yz, xz, xy.
    case_file
        Text of the case file that `msvalidate case` reads, of this ratio in all regions; of curved
        bodies it names their mesh.
    driven
        What moves the body: "loads", its "weight" or its "supports".
    """

    name: str
    state: str
    mesh: str
    E: float
    nu: float
    density: float
    thickness: float
    points: Array
    cells: Array
    modulus: Array
    mass: Array
    force: Array
    held: Array
    value: Array
    named: Array
    wanted: Array
    uncertainty: float
    quantities: dict[str, tuple[Array, float]]
    case_file: str
    driven: Driven

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.setflags(write=False)

    def __str__(self) -> str:
        return f"{self.name}, nu = {self.nu:g}"

    def at_ratio(self, nu: float) -> Array:
        """Elasticity's displacement (p, d) in m at another of Poisson's ratios.

        Between the ratios of the set a cubic through its values and slopes: within `case_set.CUBIC`
        of the largest displacement for ratios from 0 to 0.45, where each of the set's own is
        predicted from the others; beyond them the nearest cubic goes on.
        """
        given = _data(VERSION)
        u, slope = given[f"{self.name}/displacement"], given[f"{self.name}/by_ratio"]
        grid = _facts(VERSION)[self.name]["ratios"]
        return _cubic(np.array(grid), u, slope.astype(float), nu)

    def uncertainty_at_ratio(self, nu: float) -> float:
        """How far `at_ratio` may be off, over the largest displacement: most between two ratios."""
        grid = np.array(_facts(VERSION)[self.name]["ratios"])
        known = float(np.interp(nu, grid, _data(VERSION)[f"{self.name}/uncertainty"]))
        i = int(np.clip(np.searchsorted(grid, nu) - 1, 0, len(grid) - 2))
        t = (nu - grid[i]) / (grid[i + 1] - grid[i])
        return float(known + CUBIC * (4 * t * (1 - t)) ** 2)

    def in_other_state(self, order: Array) -> tuple[str, Array] | None:
        """The other plane state, and elasticity (m, d) in it at points; None if it is not known."""
        states = {"plane_stress": "plane_strain", "plane_strain": "plane_stress"}
        state = states.get(self.state, "")
        name = f"{self.name.removesuffix(f'_{self.state}')}_{state}"
        if name not in _facts(VERSION):
            return None
        return state.replace("_", " "), elastic_case(name, self.nu).wanted[order]

    @property
    def ratios(self) -> tuple[float, float]:
        """Least and largest of Poisson's ratios that the set knows."""
        grid = _facts(VERSION)[self.name]["ratios"]
        return grid[0], grid[-1]

    def coarse(self) -> dict[str, Array]:
        """What linear elements on each mesh of the case say (p, d) in m, by the mesh's name."""
        size = float(np.linalg.norm(self.wanted, axis=1).max())
        given, facts = _data(VERSION), _facts(VERSION)[self.name]
        row = _number_of(facts["ratios"], self.nu)
        found = {}
        for mesh in facts["meshes"]:
            away = given[f"{self.name}/{mesh}/away"][row].astype(float)
            if np.abs(away).max() > 0:
                found[f"linear elements on {mesh}"] = self.wanted + size * away
        return found


def elastic_case(
    body: str, nu: float = 0.3, mesh: str | None = None, state: str | None = None
) -> ElasticCase:
    """A case of the set.

    Parameters
    ----------
    body
        Such as "block_pull" or "cook"; `case_names` lists all. A full name, such as
        "cook_plane_strain", tells the state too.
    nu
        Poisson's ratio, one of the set's: 0, 0.25, 0.3, 0.4, 0.45; of rubber 0.49 and 0.4999.
    mesh
        "tri3", "quad4", "tet4" or "hex8", with "_2" or "_3" for finer ones; by default the coarsest
        of quadrilaterals or hexahedra.
    state
        "plane_stress", "plane_strain" or "space"; by default what the mesh says, in the plane the
        first that the set has.

    Raises
    ------
    CheckError
        If the set has no such case, ratio or mesh, or its file was changed.
    """
    if not isinstance(body, str):
        raise CheckError(f"case: {body!r} is no name; `case_names` lists all")
    facts = _facts(VERSION)
    name = _full_name(body, mesh, state, facts)
    known = facts[name]
    meshes = known["meshes"]
    if mesh is None:
        mesh = next(each for each in meshes if each in (PLANE[1], SPACE[1]))
    if mesh not in meshes:
        raise CheckError(f"mesh {mesh!r}: {name} has {', '.join(meshes)}; give one of them")
    row = _number_of(known["ratios"], nu, name)
    given = _data(VERSION)
    level = mesh.partition("_")[2] or "1"
    at = f"{name}/{level}"
    points, size = given[f"{at}/points"], given[f"{name}/displacement"].shape[1]
    held = given[f"{at}/held"]
    value = np.zeros(points.shape)
    value[held] = given[f"{at}/value"]
    cells = given[f"{name}/{mesh}/cells"].astype(np.int64)
    ratio, key = float(known["ratios"][row]), f"{name}/{mesh}/modulus"
    # The set has the modulus of each cell where a body has more than one.
    modulus = given[key].copy() if key in given else np.full(len(cells), float(known["E"]))
    return ElasticCase(
        name, known["state"], mesh, known["E"], ratio, known["density"], known["thickness"],
        points, cells, modulus,
        given[f"{name}/{mesh}/mass"], given[f"{name}/{mesh}/force"], held, value,
        np.arange(size), given[f"{name}/displacement"][row].copy(),
        float(given[f"{name}/uncertainty"][row]), _quantities(known, row),
        _of_ratio(known["case"], ratio), known["driven"],
    )  # fmt: skip


def case_names() -> tuple[str, ...]:
    """Full names of all cases of the set: body and state."""
    return tuple(_facts(VERSION))


def case_facts(name: str) -> dict[str, Any]:
    """What the set has of a case: its meshes, ratios, material and state."""
    return dict(_facts(VERSION)[_full_name(name, None, None, _facts(VERSION))])


def _full_name(body: str, mesh: str | None, state: str | None, facts: dict[str, Any]) -> str:
    if body in facts and state in (None, facts[body]["state"]):
        return body
    if body in facts:
        raise CheckError(
            f"state {state!r}: {body} is in {facts[body]['state']}; leave one of them out"
        )
    if state is not None and state not in STATES:
        raise CheckError(f"state {state!r}: give one of {', '.join(STATES)}")
    kind = str(mesh).partition("_")[0]
    if state is None and kind in SPACE:
        state = "space"
    states = [s for s in STATES if f"{body}_{s}" in facts]
    if mesh is not None and state is None:
        states = [s for s in states if s != "space"] or states
    if not states:
        known = sorted({facts[name]["body"] for name in facts})
        near = difflib.get_close_matches(str(body), known, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        raise CheckError(f"case {body!r}: {hint}the set has {', '.join(known)}")
    if state is None:
        return f"{body}_{states[0]}"
    if state not in states:
        raise CheckError(f"state {state!r}: {body} is in {', '.join(states)}; give one of them")
    return f"{body}_{state}"


def _number_of(ratios: list[float], nu: float, name: str = "the case") -> int:
    if not isinstance(nu, Real):
        raise CheckError(f"nu: {nu!r}; give a number")
    for i, each in enumerate(ratios):
        if abs(each - nu) < SAME_RATIO:
            return i
    raise CheckError(f"nu = {nu:g}: {name} has {', '.join(f'{x:g}' for x in ratios)}; give one")


def _quantities(known: dict[str, Any], row: int) -> dict[str, tuple[Array, float]]:
    return {
        name: (np.array(values[row]), float(uncertainties[row]))
        for name, (values, uncertainties) in known["quantities"].items()
    }


def _of_ratio(case_file: str, nu: float) -> str:
    """A case file with this ratio, in its regions too."""
    lines = case_file.split("\n")
    return "\n".join(f"nu = {nu:g}" if line.startswith("nu = ") else line for line in lines)


def _cubic(grid: Array, values: Array, slopes: Array, x: float) -> Array:
    """Cubic Hermite polynomial of the interval of the grid (k,) that holds x, or is nearest."""
    i = int(np.clip(np.searchsorted(grid, x) - 1, 0, len(grid) - 2))
    h = grid[i + 1] - grid[i]
    t = (x - grid[i]) / h
    return np.asarray(
        (1 + 2 * t) * (1 - t) ** 2 * values[i]
        + t * (1 - t) ** 2 * h * slopes[i]
        + t**2 * (3 - 2 * t) * values[i + 1]
        + t**2 * (t - 1) * h * slopes[i + 1]
    )


# The file -----------------------------------------------------------------------------------------


class _Lazy:
    """Arrays of the file, each read when it is first asked for."""

    def __init__(self, content: bytes) -> None:
        self._file = np.load(io.BytesIO(content), allow_pickle=False)
        self._read: dict[str, Array] = {}

    def __contains__(self, key: str) -> bool:
        return key in self._file.files

    def __getitem__(self, key: str) -> Array:
        if key not in self._read:
            array = self._file[key]
            array.setflags(write=False)
            self._read[key] = array
        return self._read[key]


@cache
def _data(version: int) -> _Lazy:
    return _Lazy(_checked(HERE / f"set_{version}.npz", DIGESTS[version]))


@cache
def _facts(version: int) -> dict[str, Any]:
    text = _data(version)["facts"].tobytes().decode("utf-8")
    return dict(json.loads(text))


def _checked(path: Path, digest: str) -> bytes:
    """A file's content; raise `CheckError` if it is not what was frozen."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise CheckError(
            f"set {path.name}: {error.strerror}; install msvalidate-check again"
        ) from error
    found = hashlib.sha256(content).hexdigest()
    if found != digest:
        raise CheckError(
            f"set {path.name}: its checksum is {found[:12]}, of the frozen set {digest[:12]}: the "
            "file was changed; install msvalidate-check again"
        )
    return content
