"""Bodies, materials and loads at random, to try a stated error on."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
)
from msvalidate.problem.normals import pressure
from reference_fem import box_discretisation


def material(rng, dim):
    """Ratios from 0 to .499, most of them ordinary."""
    nu = float(rng.choice([0.0, 0.2, 0.25, 0.3, 1 / 3, 0.4, 0.45, 0.49, 0.499]))
    if dim == 3:
        return Isotropic(10 ** rng.uniform(3, 11), nu, "solid")
    state = str(rng.choice(["plane_stress", "plane_strain"]))
    return Isotropic(10 ** rng.uniform(3, 11), nu, state, thickness=10 ** rng.uniform(-2, 0))


def vector(rng, dim):
    return tuple(rng.normal(size=dim).tolist())


def inner_points(rng, domain, count=60):
    low, high = np.array(domain.span).T
    found = rng.uniform(low, high, (40 * count, len(low)))
    if isinstance(domain, Polygon | Mesh):
        found = found[domain.contains(found)]
    return found[:count]


def plane_box(rng):
    box = Box((float(rng.uniform(0.5, 6)), float(rng.uniform(0.3, 2))))
    law = material(rng, 2)
    clamp = Support(box.side("left"), (0.0, 0.0))
    load = rng.integers(4)
    width, height = box.size
    if load == 0:
        loads = (Traction(box.side("right"), vector(rng, 2)),)
    elif load == 1:
        loads = (BodyForce(vector(rng, 2)),)
    elif load == 2:
        part = Region(((0.25 * width, 0.75 * width), height))
        loads = (Traction(part, vector(rng, 2)),)
    else:
        loads = (pressure(box.side("top"), box, 1.0), Traction(box.side("right"), vector(rng, 2)))
    if rng.random() < 0.3:
        return Problem(box, law, (clamp, Support(box.side("right"), vector(rng, 2))))
    return Problem(box, law, (clamp,), loads)


def outline(rng):
    many = int(rng.integers(4, 9))
    angle = np.sort(rng.uniform(0, 2 * np.pi, many))
    radius = rng.uniform(0.4, 1.4, many)
    corners = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    if np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 2.6:
        raise ProblemError("too wide")
    body = Polygon(tuple(map(tuple, (corners * 10 ** rng.uniform(-1, 1)).tolist())))
    clamped, loaded = rng.choice(many, 2, replace=False)

    def edge(i):
        return Segment(body.vertices[i], body.vertices[(i + 1) % many])

    loads = (Traction(edge(int(loaded)), vector(rng, 2)), BodyForce(vector(rng, 2)))
    held = Support(edge(int(clamped)), (0.0, 0.0))
    return Problem(body, material(rng, 2), (held,), loads)


def bent_mesh(rng):
    """A piece of a ring with bent sides, held at one end, under pressure or pulled."""
    turn, inner = float(rng.uniform(0.6, 2.5)), float(rng.uniform(0.4, 2.0))
    flat = box_discretisation(Box((1.0, 1.0)), (2 * max(1, round(2 * turn)), 2), "Q2")
    s, t = flat.points.T
    radius = inner + t
    x = np.column_stack([radius * np.cos(turn * (1 - s)), radius * np.sin(turn * (1 - s))])
    mesh = Mesh(x, flat.cells, "quad9")
    places = mesh.points[mesh.surface]

    def where(test):
        return mesh.surface[[test(each) for each in places]]

    start = where(lambda p: np.abs(np.arctan2(p[:, 1], p[:, 0]) - turn).max() < 1e-9)
    bent = where(lambda p: np.abs(np.linalg.norm(p, axis=1) - inner).max() < 1e-9)
    end = where(lambda p: np.abs(p[:, 1]).max() < 1e-9)
    mesh = mesh.named({"start": start, "inner": bent, "end": end})
    held = Support(mesh.side("start"), (0.0, 0.0))
    if rng.random() < 0.5:
        loads = (pressure(mesh.side("inner"), mesh, 1.0),)
    else:
        loads = (Traction(mesh.side("end"), vector(rng, 2)),)
    return Problem(mesh, material(rng, 2), (held,), loads)


def solid_box(rng):
    box = Box(tuple(rng.uniform(0.5, 2, 3).tolist()))
    law = material(rng, 3)
    held = Support(box.side("left"), (0.0, 0.0, 0.0))
    loads = (Traction(box.side("right"), vector(rng, 3)), BodyForce(vector(rng, 3)))
    return Problem(box, law, (held,), loads[int(rng.integers(2)) :])


KINDS = {"box": plane_box, "outline": outline, "bent": bent_mesh, "solid": solid_box}


def problems(seed, count, kinds=tuple(KINDS)):
    """Kind, problem and points, so many of each kind."""
    rng = np.random.default_rng(seed)
    for kind in kinds:
        made = 0
        while made < count:
            try:
                problem = KINDS[kind](rng)
                points = inner_points(rng, problem.domain)
            except ProblemError:
                continue
            if len(points) < 5:
                continue
            made += 1
            yield kind, problem, points
