"""The bodies of the set: how each is held, loaded and meshed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases.make.statements import (
    RUBBER,
    SPACE,
    STRAIN,
    STRESS,
    Array,
    E,
    Grid,
    Statement,
)

BLOCK = (0.5, 0.375, 0.25)
"""Sides (m) of blocks: three lengths, so that no two axes can be taken for each other."""
BEAM = (1.0, 0.25, 0.25)


def _box(sides: tuple[float, ...], cells: tuple[int, ...], sharp: tuple[int, ...] | None) -> Grid:
    """A box's grid; `sharp` are the ends along x at which lines crowd, and at both of others."""
    marks = tuple((0.0, side) for side in sides)
    if sharp is None:
        ends: tuple[tuple[int, ...], ...] = ((),) * len(sides)
    else:
        ends = (sharp, *[(0, 1)] * (len(sides) - 1))
    return Grid(marks, tuple((n,) for n in cells), ends)


def _boxed(sides: tuple[float, ...]) -> str:
    return f"[body]\nbox = [{', '.join(f'{side:g}' for side in sides)}]\n\n"


def _vector(*values: float) -> str:
    return f"[{', '.join(f'{value:g}' for value in values)}]"


def _support(on: str, components: str = "", value: str = "") -> str:
    named = ", ".join(f'"{c}"' for c in components)
    held = f"components = [{named}]\n" if components else ""
    moved = f"value = {value}\n" if value else ""
    return f"[[support]]\n{on}\n{held}{moved}"


def _side(name: str) -> str:
    return f'on = "{name}"'


def _traction(on: str, *value: float) -> str:
    return f"[[load]]\n{on}\ntraction = {_vector(*value)}\n"


PULL, PRESS, SHEAR = 1e4, 1e4, 5e3
"""Tractions (Pa): strains of a thousandth."""
GRAVITY = 9.81


def _states() -> tuple[tuple[str, int], ...]:
    return (STRESS, 2), (STRAIN, 2), (SPACE, 3)


def _uniform() -> list[Statement]:
    """Uniform states of one cell and of a block: exact for elements of every kind."""
    found = []
    for state, d in _states():
        bodies = (
            ("cell", (0.25,) * d, (1,) * d, 1),
            ("block", BLOCK[:d], (4, 3, 2)[:d], 2),
        )
        for body, sides, cells, meshes in bodies:
            for load, text in _uniform_loads(sides).items():
                grid = _box(sides, cells, None)
                found.append(Statement(f"{body}_{load}", state, _boxed(sides) + text, grid, meshes))
    return found


def _uniform_loads(sides: tuple[float, ...]) -> dict[str, str]:
    """Supports and loads of states of uniform stress."""
    d = len(sides)
    names = (("left", "right"), ("bottom", "top"), ("back", "front"))[:d]
    axes = "xyz"[:d]
    rollers = "".join(_support(_side(low), a) for (low, _), a in zip(names, axes, strict=True))
    pressed = "".join(f'[[load]]\non = "{high}"\npressure = {PRESS:g}\n' for _, high in names)
    none = [0.0] * (d - 2)
    corners = [dict.fromkeys(axes, 0.0) for _ in range(d)]
    corners[1]["x"] = sides[0]
    if d == 3:
        corners[2]["y"] = sides[1]
    held = ("xy", "y") if d == 2 else ("xyz", "yz", "z")
    pinned = "".join(
        _support(f"at = {{ {', '.join(f'{a} = {x:g}' for a, x in at.items())} }}", components)
        for at, components in zip(corners, held, strict=True)
    )
    sheared = [
        _traction(_side("right"), 0, SHEAR, *none),
        _traction(_side("left"), 0, -SHEAR, *none),
        _traction(_side("top"), SHEAR, 0, *none),
        _traction(_side("bottom"), -SHEAR, 0, *none),
    ]
    return {
        "pull": rollers + _traction(_side("right"), PULL, 0, *none),
        "pressure": rollers + pressed,
        "shear": pinned + "".join(sheared),
    }


def _clamped() -> list[Statement]:
    """A block and a beam that are clamped at one end or between plates."""
    found = []
    for state, d in _states():
        block, beam, none = BLOCK[:d], BEAM[:d], [0.0] * (d - 2)
        cells, along = (4, 3, 2)[:d], (8, 2, 2)[:d]
        left = _support(_side("left"))
        weight = f"[[load]]\ngravity = {_vector(0, -GRAVITY, *none)}\n"
        pressed = _support(_side("right"), value=_vector(-block[0] / 1024, 0, *none))
        # Clamped at the bottom: there its lines crowd along y, at the ends of the others.
        low = Grid(
            tuple((0.0, side) for side in block),
            tuple((n,) for n in cells),
            ((0, 1), (0, 1), (0, 1))[:d],
        )
        third = 3 if d == 2 else 2
        found += [
            Statement(
                "clamped_pull", state,
                _boxed(block) + left + _traction(_side("right"), PULL, 0, *none),
                _box(block, cells, (0, 1)), third,
            ),
            Statement(
                "clamped_press", state, _boxed(block) + left + pressed, _box(block, cells, (0, 1))
            ),
            Statement(
                "clamped_shear", state,
                _boxed(block) + left + _traction(_side("right"), 0, SHEAR, *none),
                _box(block, cells, (0, 1)),
            ),
            Statement(
                "block_gravity", state, _boxed(block) + _support(_side("bottom")) + weight, low
            ),
            Statement(
                "cantilever_gravity", state, _boxed(beam) + left + weight, _box(beam, along, (0,))
            ),
            Statement(
                "cantilever_load", state,
                _boxed(beam) + left + _traction(_side("right"), 0, -1e3, *none),
                _box(beam, along, (0, 1)), third,
            ),
        ]  # fmt: skip
    return found


def _cook() -> list[Statement]:
    """Cook's tapered membrane, ten times as large as a centimetre's."""
    corners = np.array([(0.0, 0.0), (0.48, 0.44), (0.48, 0.6), (0.0, 0.44)])

    def place(s: Array) -> Array:
        x, y = s.T[:, :, None]
        a, b, c, e = corners
        return np.asarray((1 - x) * (1 - y) * a + x * (1 - y) * b + x * y * c + (1 - x) * y * e)

    polygon = ", ".join(_vector(*corner) for corner in corners)
    text = (
        f"[body]\npolygon = [{polygon}]\n\n"
        + _support(_side("left"))
        + _traction(_side("right"), 0, 6.25e3)
    )
    grid = Grid(((0.0, 1.0),) * 2, ((4,), (4,)), ((0, 1), (0, 1)), place)
    return [Statement("cook", state, text, grid, 3) for state in (STRESS, STRAIN)]


def _l_shape() -> list[Statement]:
    """An L, held at the end of its upright arm and pulled down at the end of the other."""
    corners = [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]
    text = (
        f"[body]\npolygon = [{', '.join(_vector(*corner) for corner in corners)}]\n\n"
        + _support(_side("edge 5"))
        + _traction(_side("edge 2"), 0, -1e3)
    )
    grid = Grid(
        ((0.0, 0.5, 1.0),) * 2,
        ((2, 2),) * 2,
        ((0, 1, 2), (0, 1, 2)),
        kept=lambda middle: np.asarray((middle < 0.5).any(axis=1)),
    )
    return [Statement("l_shape", state, text, grid) for state in (STRESS, STRAIN)]


def _polar(inner: float, outer: float) -> Callable[[Array], Array]:
    def place(s: Array) -> Array:
        r, angle = inner + (outer - inner) * s[:, 0], np.pi / 2 * s[:, 1]
        return np.column_stack([r * _cos(s[:, 1], angle), r * _sin(s[:, 1], angle)])

    return place


def _cos(part: Array, angle: Array) -> Array:
    """Cosine that is 0 at a right angle."""
    return np.where(part == 1, 0.0, np.cos(angle))


def _sin(part: Array, angle: Array) -> Array:
    return np.where(part == 1, 1.0, np.sin(angle))


SHORT = 1e-6
"""Distance (m) within which a place lies on a straight side."""


def _rings() -> list[Statement]:
    """A quarter of a ring: under pressure from inside (Lamé), and pinched."""
    inner, outer = 0.5, 1.0
    sides = {
        "inner": lambda x: np.abs(np.hypot(*x.T) - inner) < SHORT,
        "bottom": lambda x: np.abs(x[:, 1]) < SHORT,
        "left": lambda x: np.abs(x[:, 0]) < SHORT,
    }
    start = (
        '[body]\nmesh = "body.msh"\n\n'
        + _support(_side("bottom"), "y")
        + _support(_side("left"), "x")
    )
    marks, cells = ((0.0, 1.0), (0.0, 1.0)), ((2,), (6,))
    grid = Grid(marks, cells, ((), ()), _polar(inner, outer))
    # The shear on the pinched cut ends at free arcs, where stress has no limit.
    ended = Grid(marks, cells, ((0, 1), (1,)), _polar(inner, outer))
    pressure = f'[[load]]\non = "inner"\npressure = {PRESS:g}\n'
    pinch = _traction(_side("left"), 0, -2e3)
    found = []
    for state in (STRESS, STRAIN):
        found.append(Statement("lame_ring", state, start + pressure, grid, 2, sides=sides))
        found.append(Statement("pinched_ring", state, start + pinch, ended, 2, sides=sides))
    return found


def _plate_with_hole() -> list[Statement]:
    """A quarter of a square plate with a hole, pulled."""
    radius, side = 0.25, 1.0

    def place(s: Array) -> Array:
        angle = np.pi / 2 * s[:, 1]
        along = np.column_stack([_cos(s[:, 1], angle), _sin(s[:, 1], angle)])
        edge = side * along / np.abs(along).max(axis=1, keepdims=True)
        return np.asarray(radius * along + s[:, :1] * (edge - radius * along))

    sides = {
        "right": lambda x: np.abs(x[:, 0] - side) < SHORT,
        "bottom": lambda x: np.abs(x[:, 1]) < SHORT,
        "left": lambda x: np.abs(x[:, 0]) < SHORT,
    }
    text = (
        '[body]\nmesh = "body.msh"\n\n'
        + _support(_side("bottom"), "y")
        + _support(_side("left"), "x")
        + _traction(_side("right"), PULL, 0)
    )
    grid = Grid(((0.0, 1.0), (0.0, 0.5, 1.0)), ((4,), (3, 3)), ((), ()), place)
    return [
        Statement("plate_hole", state, text, grid, 2, sides=sides) for state in (STRESS, STRAIN)
    ]


def _in_space() -> list[Statement]:
    """A square bar twisted by tractions around its end."""
    w, end = BEAM[1], "x = [0.75, 1]"
    turned = [
        (f"y = {w:g}", (0, 0, -PULL)),
        ("y = 0", (0, 0, PULL)),
        (f"z = {w:g}", (0, PULL, 0)),
        ("z = 0", (0, -PULL, 0)),
    ]
    loads = "".join(_traction(f"at = {{ {end}, {face} }}", *value) for face, value in turned)
    text = _boxed(BEAM) + _support(_side("left")) + loads
    grid = Grid(
        ((0.0, 0.75, 1.0), (0.0, w), (0.0, w)), ((6, 2), (2,), (2,)), ((0, 1, 2), (0, 1), (0, 1))
    )
    return [Statement("twisted_bar", SPACE, text, grid)]


def _rubber() -> list[Statement]:
    """A block near nu = 1/2, clamped at its bottom, pressed and sheared on top."""
    found = []
    for state, d in ((STRAIN, 2), (SPACE, 3)):
        sides, none = BLOCK[:d], [0.0] * (d - 2)
        text = (
            _boxed(sides)
            + _support(_side("bottom"))
            + _traction(_side("top"), SHEAR, -PRESS, *none)
        )
        grid = Grid(
            tuple((0.0, side) for side in sides),
            tuple((n,) for n in (4, 3, 2)[:d]),
            ((0, 1), (0, 1), (0, 1))[:d],
        )
        found.append(Statement("rubber_block", state, text, grid, 2, RUBBER))
    return found


def _bimaterial() -> list[Statement]:
    """A beam, clamped, whose far half is four times as stiff."""
    found = []
    for state, d in ((STRESS, 2), (SPACE, 3)):
        beam, none = BEAM[:d], [0.0] * (d - 2)
        region = f"[[region]]\nbox = {{ x = [0.5, 1] }}\nE = {4 * E:g}\nnu = NU\n"
        text = (
            _boxed(beam)
            + region
            + _support(_side("left"))
            + _traction(_side("right"), PULL, -1e3, *none)
        )
        marks = ((0.0, 0.5, 1.0), *[(0.0, side) for side in beam[1:]])
        cells = ((4, 4), *[(2,)] * (d - 1))
        sharp = ((0, 1, 2), *[(0, 1)] * (d - 1))
        found.append(Statement("bimaterial_bar", state, text, Grid(marks, cells, sharp)))
    return found


def all_statements() -> tuple[Statement, ...]:
    """Everything that the set asks, in order of name."""
    made = [
        *_uniform(), *_clamped(), *_cook(), *_l_shape(), *_rings(), *_plate_with_hole(),
        *_in_space(), *_rubber(), *_bimaterial(),
    ]  # fmt: skip
    return tuple(sorted(made, key=lambda each: each.name))
