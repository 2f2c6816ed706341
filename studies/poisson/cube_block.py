"""The cube under end load: its lattices, loadings, definitions of its ratio, and its reference."""

from __future__ import annotations

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.constants.stiffness import moduli
from msvalidate.springs.lattice import Constants, Pattern, patterns
from reference_fem.richardson import Estimate, extrapolate_each

SIDE = 1.0
BOX = kit.Box((SIDE,) * 3)
EIGHTH = kit.Box((SIDE / 2,) * 3)
STRAIN = 1e-3
"""Nominal axial strain; every answer is linear."""
LATTICES: dict[str, tuple[Pattern, Constants]] = {
    "cubic 18": (patterns.cubic18(), patterns.cubic18().rules["isotropic"]),
    "cubic 26": (patterns.cubic26(), patterns.cubic26().rules["equal"]),
    "FCC, nearest": (patterns.fcc(), patterns.fcc().rules["nearest only"]),
    "FCC": (patterns.fcc(), patterns.fcc().rules["isotropic"]),
    "BCC": (patterns.bcc(), patterns.bcc().rules["isotropic"]),
}
"""Name in tables -> pattern and its constants (N/m)."""
LATERAL = ("faces", "middle")
MESH, GRADING = 8, 2.0
"""Quadratic elements on a side of an eighth of the cube, on the finest of three meshes, and their
grading towards the cube's faces. A clamped edge of exponent λ, here 0.67 to 0.75, leaves an error
of order 2λ in even meshes, of order 4λ in these, near 3: 32 even linear elements on a side are no
nearer, and take 7 times as long."""


def loaded_cube(loading: str, tensor: kit.Array) -> kit.Problem:
    """Cube pulled along x: "slide", "traction" or "clamped", as `block.loaded_block` in the plane.

    Parameters
    ----------
    loading
        "slide": end displacement prescribed, ends free to slide along y and z. "traction": uniform
        traction on both ends, statically determinate supports. "clamped": all components prescribed
        on both ends.
    tensor
        (6, 6) in Pa.
    """
    left, right = BOX.side("left"), BOX.side("right")
    corner, beside, above = (
        kit.Region(at) for at in ((0.0,) * 3, (0.0, SIDE, 0.0), (0.0, 0.0, SIDE))
    )
    pull = STRAIN * SIDE
    loads: tuple[kit.Traction, ...] = ()
    supports: tuple[kit.Support, ...]
    if loading == "slide":
        supports = (
            kit.Support(left, (0.0, None, None)),
            kit.Support(right, (pull, None, None)),
            kit.Support(corner, (None, 0.0, 0.0)),
            kit.Support(beside, (None, None, 0.0)),
        )
    elif loading == "clamped":
        supports = (kit.Support(left, (0.0,) * 3), kit.Support(right, (pull, 0.0, 0.0)))
    elif loading == "traction":
        stress = STRAIN * moduli(tensor).E
        supports = (
            kit.Support(corner, (0.0,) * 3),
            kit.Support(beside, (0.0, None, 0.0)),
            kit.Support(above, (0.0, None, None)),
        )
        loads = (kit.Traction(left, (-stress, 0.0, 0.0)), kit.Traction(right, (stress, 0.0, 0.0)))
    else:
        raise kit.ProblemError(f"loading {loading!r}: choose from slide, traction, clamped")
    return kit.Problem(BOX, kit.Anisotropic(tensor), supports, loads, name=f"cube, {loading}")


def spring_cube(
    name: str, weights: str, loading: str, cells: int, constants: Constants | None = None
) -> tuple[kit.Problem, kit.Network]:
    """The cube as a problem, its material the tensor of the lattice's interior, and as springs.

    `constants` (N/m) are by default the lattice's own.
    """
    pattern, usual = LATTICES[name]
    constants = constants or usual
    grid = lattice.fill(pattern, BOX, cells)
    problem = loaded_cube(loading, interior_tensor(grid, constants, weights))
    return problem, lattice_network(problem, grid, constants, weights=weights)


def axial_strain(points: kit.Array, displacement: kit.Array) -> float:
    """Difference of the plain mean displacement of the two ends, over the length."""
    return _apart(points, displacement, 0, np.ones(len(points), dtype=bool)) / SIDE


def ratio(points: kit.Array, displacement: kit.Array, lateral: str = "faces") -> float:
    """Poisson's ratio of the cube: minus lateral over axial strain, mean of the two lateral axes.

    ``faces``: lateral strain between the plain means of all nodes of opposite side faces, edges and
    corners included. ``middle``: of those at half length; where there are none, of the two nearest
    columns.
    """
    chosen = np.ones(len(points), dtype=bool)
    if lateral == "middle":
        columns = np.unique(np.round(points[_at(points[:, 1], SIDE), 0], 12))
        distance = np.abs(columns - SIDE / 2)
        columns = columns[distance < distance.min() + 1e-9]
        chosen = (np.abs(points[:, [0]] - columns) < 1e-9).any(axis=1)
    across = [_apart(points, displacement, axis, chosen) / SIDE for axis in (1, 2)]
    return float(-np.mean(across) / axial_strain(points, displacement))


def _apart(points: kit.Array, displacement: kit.Array, axis: int, chosen: kit.Mask) -> float:
    """By how much (m) two opposite sides move apart, in the plain mean of their chosen nodes."""
    far, near = (chosen & _at(points[:, axis], end) for end in (SIDE, 0.0))
    return float(displacement[far, axis].mean() - displacement[near, axis].mean())


def _at(values: kit.Array, place: float) -> kit.Mask:
    return np.asarray(np.abs(values - place) < 1e-9)


def clamped_reference(name: str, sizes: tuple[int, ...]) -> Estimate:
    """Ratios of the clamped elastic cube at the points of every size, faces and middle in turn.

    The body is symmetric about its three middle planes: an eighth is solved and folded out.
    """
    pattern, constants = LATTICES[name]
    grids = [lattice.fill(pattern, BOX, n) for n in sizes]
    tensor = interior_tensor(grids[0], constants, "shared")
    points = np.concatenate([grid.points for grid in grids])
    ends = np.cumsum([len(grid.points) for grid in grids])[:-1]
    away = points - SIDE / 2
    side, folded = np.where(away < 0, -1.0, 1.0), np.abs(away)
    problem = _clamped_eighth(tensor)

    def sampled(cells: int) -> kit.Array:
        mesh = reference_fem.box_discretisation(EIGHTH, cells, "H2", GRADING, "high")
        move = side * reference_fem.solve_problem(problem, mesh).at(folded)
        moves = np.split(move, ends)
        return np.array(
            [
                ratio(grid.points, u, where)
                for grid, u in zip(grids, moves, strict=True)
                for where in LATERAL
            ]
        )

    return extrapolate_each([sampled(MESH // part) for part in (4, 2, 1)], MESH)


def _clamped_eighth(tensor: kit.Array) -> kit.Problem:
    """The eighth beyond the cube's middle planes, which symmetry holds; pulled by its end."""
    middle = tuple(
        kit.Support(EIGHTH.side(name), tuple(0.0 if a == axis else None for a in range(3)))
        for axis, name in enumerate(("left", "bottom", "back"))
    )
    end = kit.Support(EIGHTH.side("right"), (STRAIN * SIDE / 2, 0.0, 0.0))
    return kit.Problem(EIGHTH, kit.Anisotropic(tensor), (*middle, end), name="eighth cube, clamped")
