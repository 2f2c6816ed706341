"""The same questions to another program: NGSolve, elements of high degree on hp-refined meshes.

    python -m cases.make peer

It reads the text of the case file by itself, builds the body from OpenCascade's shapes and writes
Hooke's law down again: nothing of the spring solver or of `reference_fem` is used. Each answer is
found twice, by degree `LOW` and by degree `HIGH` with one more layer of cells at each corner and
edge; the difference of the two is its uncertainty.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import ngsolve as ng
import numpy as np
from netgen import occ

from cases.make.answer import Answer
from cases.make.meshes import coarsest_nodes
from cases.make.statements import Statement

Array = np.ndarray
LOW, HIGH = {2: (7, 8), 3: (3, 2)}, {2: (9, 10), 3: (4, 2)}
"""Degree, and layers of cells that shrink towards corners and edges."""
SHRINK = 0.15
"""Factor between the sizes of neighbouring layers."""
COARSE = {2: 0.35, 3: 1.0}
"""Largest cell, in narrowest sides of the body."""
NEAR = 1e-6
"""Distance (m) within which the middle of a side lies where the case says."""
AXES = "xyz"
ENDS = {
    "left": (0, 0),
    "right": (0, 1),
    "bottom": (1, 0),
    "top": (1, 1),
    "back": (2, 0),
    "front": (2, 1),
}
SAFE = 1e-10
"""Of the size of forces, what sums of them are known to."""


@dataclass(frozen=True, eq=False)
class Made:
    """A body's mesh, and what is known of the pieces of its surface.

    Parameters
    ----------
    mesh
        NGSolve's.
    pieces
        Name of each piece -> its middle (d,) in m.
    low, high
        Ends (d,) in m of the body.
    polygon
        Its vertices, where it is one.
    """

    mesh: Any
    pieces: dict[str, Array]
    low: Array
    high: Array
    polygon: list[list[float]] | None


def answer_of(statement: Statement, nu: float) -> Answer:
    """What NGSolve says of a statement at one ratio."""
    given = tomllib.loads(statement.case_file(nu))
    coarse = _solve(statement, given, nu, LOW[statement.dim])
    fine = _solve(statement, given, nu, HIGH[statement.dim])
    size = fine.uncertainty
    uncertainty = {"displacement": _away(fine.displacement, coarse.displacement)}
    uncertainty |= {"by_ratio": _away(fine.by_ratio, coarse.by_ratio)}
    uncertainty |= {
        name: max(_away(value, coarse.quantities[name]), size[name.split()[0]])
        for name, value in fine.quantities.items()
    }
    return Answer(
        fine.displacement, fine.by_modulus, fine.by_ratio, fine.quantities, uncertainty, np.nan,
        fine.nodes,
    )  # fmt: skip


def _away(a: Array, b: Array) -> float:
    return float(np.abs(a - b).max())


# The body ----------------------------------------------------------------------------------------


def _make(statement: Statement, given: dict[str, Any], layers: int, degree: int) -> Made:
    d = statement.dim
    shape = _shape(statement, given)
    singular = any(statement.grid.sharp)
    if singular:
        for vertex in shape.vertices:
            vertex.hpref = 1
        if d == 3:
            for edge in shape.edges:
                edge.hpref = 1
    pieces = {}
    for i, piece in enumerate(shape.edges if d == 2 else shape.faces):
        piece.name = f"piece{i}"
        middle = piece.center
        pieces[piece.name] = np.array([middle.x, middle.y, middle.z][:d])
    low, high = _span(given)
    size = COARSE[d] * float((high - low).min())
    if statement.sides is not None:
        size /= 4
    raw = occ.OCCGeometry(shape, dim=d).GenerateMesh(maxh=size)
    mesh = ng.Mesh(raw)
    if singular:
        mesh.RefineHP(layers, SHRINK)
    if statement.sides is not None:
        mesh.Curve(degree + 1)
    polygon = given["body"].get("polygon")
    return Made(mesh, pieces, low, high, polygon)


def _span(given: dict[str, Any]) -> tuple[Array, Array]:
    """Ends (m) of the body; of curved ones the unit square."""
    if "box" in given["body"]:
        sides = np.array(given["body"]["box"], dtype=float)
        return np.zeros(len(sides)), sides
    if "polygon" in given["body"]:
        corners = np.array(given["body"]["polygon"], dtype=float)
        return corners.min(axis=0), corners.max(axis=0)
    return np.zeros(2), np.ones(2)


def _shape(statement: Statement, given: dict[str, Any]) -> Any:
    body = given["body"]
    if "polygon" in body:
        (x, y), *rest = body["polygon"]
        plane = occ.WorkPlane().MoveTo(x, y)
        for corner in rest:
            plane = plane.LineTo(*corner)
        return plane.Close().Face()
    if "box" in body:
        cuts = [0.0, *_cuts(given), body["box"][0]]
        parts = [_brick(a, b, body["box"][1:]) for a, b in pairwise(cuts)]
        for a, part in zip(cuts[:-1], parts, strict=True):
            material = "far" if given.get("region") and a > 0 else "near"
            (part.faces if len(body["box"]) == 2 else part.solids).name = material
        return parts[0] if len(parts) == 1 else occ.Glue(parts)
    plane = occ.WorkPlane()
    if statement.body == "plate_hole":
        return plane.Rectangle(1, 1).Face() - occ.WorkPlane().Circle(0, 0, 0.25).Face()
    ring = plane.Circle(0, 0, 1).Face() - occ.WorkPlane().Circle(0, 0, 0.5).Face()
    return ring * occ.WorkPlane().Rectangle(2, 2).Face()


def _brick(a: float, b: float, others: list[float]) -> Any:
    if len(others) == 1:
        return occ.WorkPlane().MoveTo(a, 0).Rectangle(b - a, others[0]).Face()
    return occ.Box(occ.Pnt(a, 0, 0), occ.Pnt(b, *others))


def _cuts(given: dict[str, Any]) -> list[float]:
    """Places along x at which a load or a material ends inside a side."""
    found = {region["box"]["x"][0] for region in given.get("region", [])}
    found |= {load["at"]["x"][0] for load in given.get("load", []) if "at" in load}
    return sorted(found)


def _pieces(made: Made, part: dict[str, Any]) -> str:
    """NGSolve's name of all pieces of the surface that a support or load names."""
    found = [name for name, middle in made.pieces.items() if _is_on(made, part, middle)]
    if not found:
        raise ValueError(f"no piece of the surface is {part}")
    return "|".join(found)


def _is_on(made: Made, part: dict[str, Any], middle: Array) -> bool:
    if "at" in part:
        for axis, x in zip(AXES, middle, strict=False):
            asked = part["at"].get(axis)
            if asked is None:
                continue
            low, high = asked if isinstance(asked, list) else (asked, asked)
            if not low - NEAR <= x <= high + NEAR:
                return False
        return True
    name = part["on"]
    if name.startswith("edge "):
        number = int(name.split()[1])
        corners = np.array(made.polygon, dtype=float)
        return bool(
            np.abs(corners[[number - 1, number % len(corners)]].mean(axis=0) - middle).max() < NEAR
        )
    if name == "inner":
        return bool(np.hypot(*middle) < 0.75 and min(middle) > 0.1)
    along, end = ENDS[name]
    return bool(abs((made.low, made.high)[end][along] - middle[along]) < NEAR)


# The law and the equations -----------------------------------------------------------------------


def _lame(E: float, nu: float, state: str | None) -> tuple[float, float, float, float]:
    """λ and μ (Pa), and what they change by with nu."""
    mu, by_mu = E / (2 * (1 + nu)), -E / (2 * (1 + nu) ** 2)
    if state == "plane_stress":
        return E * nu / (1 - nu**2), mu, E * (1 + nu**2) / (1 - nu**2) ** 2, by_mu
    under = (1 + nu) * (1 - 2 * nu)
    return E * nu / under, mu, E * (1 + 2 * nu**2) / under**2, by_mu


def _solve(
    statement: Statement, given: dict[str, Any], nu: float, effort: tuple[int, int]
) -> Answer:
    degree, layers = effort
    d = statement.dim
    made = _make(statement, given, layers, degree)
    law, thickness = given["material"], given["material"].get("thickness", 1.0)
    near = _lame(law["E"], nu, law.get("state"))
    far = _lame(given["region"][0]["E"], nu, law.get("state")) if given.get("region") else near
    lam, mu, by_lam, by_mu = (
        made.mesh.MaterialCF({"far": b}, default=a) for a, b in zip(near, far, strict=True)
    )
    held: dict[str, list[str]] = {axis: [] for axis in AXES[:d]}
    for support in given["support"]:
        for axis in support.get("components", list(held)):
            held[axis].append(_pieces(made, support))
    V = ng.VectorH1(
        made.mesh, order=degree, **{f"dirichlet{a}": "|".join(on) for a, on in held.items()}
    )
    u, v = V.TnT()

    def stress(w: Any, lam: Any = lam, mu: Any = mu) -> Any:
        strain = ng.Sym(ng.Grad(w))
        return lam * ng.Trace(strain) * ng.Id(d) + 2 * mu * strain

    a = ng.BilinearForm(V, symmetric=True, condense=True)
    a += thickness * ng.InnerProduct(stress(u), ng.Sym(ng.Grad(v))) * ng.dx
    whole = ng.BilinearForm(V, symmetric=True)
    whole += thickness * ng.InnerProduct(stress(u), ng.Sym(ng.Grad(v))) * ng.dx
    f = ng.LinearForm(V)
    _load(f, v, made, given, thickness)
    with ng.TaskManager():
        a.Assemble()
        whole.Assemble()
        f.Assemble()
        move = ng.GridFunction(V)
        _prescribe(move, made, given)
        inverse = a.mat.Inverse(V.FreeDofs(coupling=True), inverse="sparsecholesky")
        _add_solution(a, inverse, move, f.vec - whole.mat * move.vec)
        change = ng.GridFunction(V)
        right = ng.LinearForm(V)
        right += (
            -thickness * ng.InnerProduct(stress(move, by_lam, by_mu), ng.Sym(ng.Grad(v))) * ng.dx
        )
        right.Assemble()
        _add_solution(a, inverse, change, right.vec)
    loaded = bool(given.get("load"))
    points = coarsest_nodes(statement.grid)
    found = _values(made, points, move)
    residual = whole.mat * move.vec - f.vec
    quantities = _quantities(made, given, V, move, residual, stress, thickness)
    force = float(np.abs(f.vec.FV().NumPy()).sum()) or float(
        max(np.abs(value).max() for key, value in quantities.items() if key.startswith("reaction"))
    )
    size, volume = float((made.high - made.low).max()), float(np.prod(made.high - made.low))
    floors = {"reaction": SAFE * force, "strain": 0.0, "mean": SAFE * force * size / volume}
    return Answer(
        found, -found if loaded else 0 * found, _values(made, points, change), quantities, floors,
        np.nan, V.ndof,
    )  # fmt: skip


def _add_solution(a: Any, inverse: Any, move: Any, right: Any) -> None:
    """Solve for what `right` asks, the inner unknowns of cells taken out first."""
    rest = right.CreateVector()
    rest.data = right
    rest.data += a.harmonic_extension_trans * rest
    step = rest.CreateVector()
    step.data = inverse * rest
    step.data += a.harmonic_extension * step
    step.data += a.inner_solve * rest
    move.vec.data += step


def _load(f: Any, v: Any, made: Made, given: dict[str, Any], thickness: float) -> None:
    for load in given.get("load", []):
        if "gravity" in load:
            pull = ng.CF(tuple(given["material"]["density"] * g for g in load["gravity"]))
            f += thickness * ng.InnerProduct(pull, v) * ng.dx
            continue
        on = made.mesh.Boundaries(_pieces(made, load))
        if "traction" in load:
            acting = ng.CF(tuple(load["traction"]))
        else:  # on the ring's inner arc; NGSolve's normals of edges point either way
            acting = load["pressure"] * ng.CF((ng.x, ng.y)) / ng.sqrt(ng.x**2 + ng.y**2)
        f += thickness * ng.InnerProduct(acting, v.Trace()) * ng.ds(definedon=on)


def _prescribe(move: Any, made: Made, given: dict[str, Any]) -> None:
    for support in given["support"]:
        value = support.get("value")
        if value is not None:
            move.Set(ng.CF(tuple(value)), definedon=made.mesh.Boundaries(_pieces(made, support)))


def _values(made: Made, points: Array, field: Any) -> Array:
    """A field (p, d) at points; those on bent sides may lie a rounding outside."""
    middle = (made.low + made.high) / 2
    found = []
    for x in points:
        for part in (0.0, 1e-12, 1e-10, 1e-8):
            try:
                found.append(field(made.mesh(*(x + part * (middle - x)))))
                break
            except Exception:  # noqa: BLE001, S112
                continue
        else:
            raise ValueError(f"{x}: in no cell")
    return np.array(found)


def _quantities(
    made: Made,
    given: dict[str, Any],
    V: Any,
    move: Any,
    residual: Any,
    stress: Any,
    thickness: float,
) -> dict[str, Array]:
    d = len(made.low)
    found = {}
    for i, support in enumerate(given["support"], 1):
        on = made.mesh.Boundaries(_pieces(made, support))
        held = support.get("components", list(AXES[:d]))
        force = np.zeros(d)
        for k, axis in enumerate(AXES[:d]):
            if axis in held:
                along = ng.GridFunction(V)
                along.Set(ng.CF(tuple(float(j == k) for j in range(d))), definedon=on)
                force[k] = ng.InnerProduct(along.vec, residual.Evaluate())
        found[f"reaction {i}"] = force
    mesh = made.mesh
    strain = ng.Sym(ng.Grad(move))
    work = ng.Integrate(ng.InnerProduct(stress(move), strain), mesh, order=2 * V.globalorder)
    found["strain energy"] = np.array([thickness * work / 2])
    mean = np.array(ng.Integrate(stress(move), mesh, order=2 * V.globalorder)).reshape(d, d)
    mean /= ng.Integrate(ng.CF(1.0), mesh)
    pairs = [(0, 0), (1, 1), (0, 1)] if d == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    found["mean stress"] = np.array([mean[pair] for pair in pairs])
    return found
