"""Solids for the question `solid`: load cases in space, springs, and elastic bodies by FEM."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_edge_exponent
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import isotropic_moduli, moduli, pattern_tensor
from msvalidate.springs.lattice import Constants, Pattern, PatternLattice, fill, patterns
from reference_fem.body import nodal_forces
from reference_fem.richardson import extrapolate

from .load_cases import MODULUS

LENGTH = 4.0
"""Of the cantilever, in heights."""
SMOOTH = 2.0
"""Order of linear elements, and of lattices, where nothing is singular."""
COARSEST, QUICK_COARSEST = 4, 2
"""Elements through the height of the coarsest of four meshes; the finest has eight times that."""
DRAWN = 8
"""Cells through the height of the bodies that are drawn."""


@dataclass(frozen=True)
class SolidCase:
    """A box 1 m high and wide, clamped on one side, under a uniform traction (Pa) on another.

    It is symmetric about z = 0.5 m. About its other middle plane along the load or across it,
    `middle` of the axis numbered `axis`, the displacement is symmetric or antisymmetric.
    """

    name: str
    length: float
    clamped: str
    loaded: str
    traction: tuple[float, float, float]
    axis: int
    middle: str
    symmetric: bool

    @property
    def box(self) -> kit.Box:
        """The body."""
        return kit.Box((self.length, 1.0, 1.0))


CASES = {
    case.name: case
    for case in (
        SolidCase("cube, shear", 1.0, "bottom", "top", (400.0, 0.0, 0.0), 0, "right", False),
        SolidCase("cube, pressure", 1.0, "bottom", "top", (0.0, -1000.0, 0.0), 0, "right", True),
        SolidCase("cantilever", LENGTH, "left", "right", (0.0, -40.0, 0.0), 1, "top", False),
    )
}
"""Strains of about 1 %, a deflection of 3 % of the length; every answer is linear."""


@dataclass(frozen=True)
class SolidModel:
    """Springs of a pattern whose solid has the modulus `MODULUS` along its axes."""

    name: str
    pattern: Pattern
    shares: Constants

    @property
    def constants(self) -> Constants:
        """Spring constants (N/m) at a spacing of 1 m; they grow with the spacing."""
        modulus = moduli(pattern_tensor(self.pattern, self.shares)).E
        return tuple(MODULUS / modulus * share for share in self.shares)

    @property
    def tensor(self) -> kit.Array:
        """Of the solid, (6, 6) in Pa."""
        return pattern_tensor(self.pattern, self.constants)


MODELS = {
    model.name: model
    for model in (
        SolidModel("cubic 18", patterns.cubic18(), patterns.cubic18().rules["isotropic"]),
        SolidModel("cubic 26", patterns.cubic26(), patterns.cubic26().rules["equal"]),
    )
}
"""The first is isotropic, the second has the Zener ratio 7/3."""


def targets(model: SolidModel) -> dict[str, kit.Isotropic]:
    """Isotropic bodies that a model may be meant to be."""
    choices = {
        "axial modulus and ratio": moduli(model.tensor),
        "nearest isotropic": isotropic_moduli(model.tensor),
    }
    return {name: kit.Isotropic(E=m.E, nu=m.nu, state="solid") for name, m in choices.items()}


def problem(case: SolidCase, tensor: kit.Array) -> kit.Problem:
    """The case on its body."""
    support = kit.Support(case.box.side(case.clamped), (0.0, 0.0, 0.0))
    load = kit.Traction(case.box.side(case.loaded), case.traction)
    return kit.Problem(case.box, kit.Anisotropic(tensor), (support,), (load,), name=case.name)


def quarter(case: SolidCase, tensor: kit.Array) -> kit.Problem:
    """The case on the quarter below its two planes of symmetry.

    In a plane of symmetry the component across it vanishes, of antisymmetry those in it.
    """
    box = quarter_box(case)
    held = [0.0 if (a == case.axis) == case.symmetric else None for a in range(3)]
    supports = (
        kit.Support(box.side(case.clamped), (0.0, 0.0, 0.0)),
        kit.Support(box.side("front"), (None, None, 0.0)),
        kit.Support(box.side(case.middle), tuple(held)),
    )
    load = kit.Traction(box.side(case.loaded), case.traction)
    return kit.Problem(
        box, kit.Anisotropic(tensor), supports, (load,), name=f"quarter of {case.name}"
    )


def quarter_box(case: SolidCase) -> kit.Box:
    """The quarter of a case's body."""
    edges = list(case.box.size)
    edges[2] = edges[case.axis] = 0.5
    return kit.Box(tuple(edges))


def folded(case: SolidCase, points: kit.Array) -> tuple[kit.Array, kit.Array]:
    """Points (n, 3) in m in the quarter, and signs (n, 3) of displacements there and here."""
    place, sign = points.copy(), np.ones_like(points)
    for axis, symmetric in ((2, True), (case.axis, case.symmetric)):
        beyond = points[:, axis] > 0.5
        place[beyond, axis] = 1 - points[beyond, axis]
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        sign[beyond] *= mirror if symmetric else -mirror
    return place, sign


def grid(model: SolidModel, case: SolidCase, cells: int) -> PatternLattice:
    """The lattice with `cells` through the height."""
    along = round(case.length * cells)
    return fill(model.pattern, case.box, (along, cells, cells))


@dataclass(frozen=True, eq=False)
class Moved:
    """A body under its load.

    `mean`: displacement (m) of the loaded side along the load, as the load weighs its points.
    `at_points`: displacement (n, 3) in m at the points of the lattice.
    """

    mean: float
    at_points: kit.Array


def spring_body(
    candidate: kit.DisplacementSolver, model: SolidModel, case: SolidCase, cells: int
) -> Moved:
    """The candidate's answer, edges and faces shared."""
    lattice = grid(model, case, cells)
    constants = tuple(k * lattice.spacing for k in model.constants)
    asked = problem(case, model.tensor)
    network = lattice_network(asked, lattice, constants)
    move = candidate(asked, network, "linear")
    return Moved(along_load(network.force, move), move)


def along_load(force: kit.Array, move: kit.Array) -> float:
    """Mean displacement (m) along a load in one direction: its work over its size."""
    return float((force * move).sum() / np.linalg.norm(force.sum(axis=0)))


@dataclass(frozen=True, eq=False)
class ElasticSolid:
    """An elastic body: `mean` as in `Moved` with its estimated error (m), and at the points drawn.

    `at_points` (n, 3) in m belong to the lattice with `DRAWN` cells through the height.
    """

    mean: float
    uncertainty: float
    at_points: kit.Array


def elastic_body(coarsest: int, asked: tuple[str, kit.Array]) -> ElasticSolid:
    """The elastic body of a (load case, tensor) by FEM on a quarter of it, at vanishing spacing."""
    case, tensor = CASES[asked[0]], asked[1]
    part = quarter(case, tensor)
    points, sign = folded(case, grid(MODELS["cubic 18"], case, DRAWN).points)
    fields: list[kit.Array] = []

    def mean(cells: int) -> float:
        mesh = reference_fem.box_discretisation(quarter_box(case), elements(case, cells), "H1")
        solution = reference_fem.solve_problem(part, mesh)
        if cells >= 4 * coarsest:
            fields.append(solution.at(points))
        return along_load(nodal_forces(part, mesh), solution.displacement)

    order = 2 * clamped_edge_exponent(tensor)
    value, uncertainty = extrapolate(mean, coarsest, (order, SMOOTH))
    # Away from the edges a field falls with their order too; two meshes are enough to draw it.
    coarse, fine = fields
    field = sign * (fine + (fine - coarse) / (2**order - 1))
    return ElasticSolid(float(value[0]), float(uncertainty[0]), field)


def elements(case: SolidCase, cells: int) -> tuple[int, int, int]:
    """Elements along the axes of the quarter, `cells` through the height of the whole."""
    size = quarter_box(case).size
    nx, ny, nz = (round(edge * cells) for edge in size)
    return nx, ny, nz
