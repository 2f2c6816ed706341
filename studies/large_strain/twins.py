"""Twins: which spring networks are finite elements, node for node?

Question   A body bent by its ends, and random states: forces and displacements of springs beside
           those of elements on the same points.
Candidate  Equilibrium of the network, springs of no rest length beside cells under pressure (route
           "neo-Hookean"), or Green's springs.
Reference  Linear triangles and tetrahedra of the neo-Hookean law and of St. Venant-Kirchhoff's, and
           quadrilaterals and hexahedra with one mean J a cell.
Expected   On these meshes, at these ratios and strains, the same to rounding; not so with other
           constants, and not Green's springs on squares.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
import skfem
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from scipy.sparse import kron
from skfem.models.poisson import laplace

from msvalidate import kit
from msvalidate.problem import SHAPES, Array
from msvalidate.problem.records import replace
from msvalidate.springs import lattice
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import patterns
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.laws.green import GREEN
from reference_fem.large_strain.by_cell import neo_hookean, st_venant_kirchhoff
from reference_fem.large_strain.equilibrium import deform
from reference_fem.large_strain.solid import Solid
from reference_fem.mesh.discretisation import make_discretisation

SIZE, THICKNESS, E = 0.37, 0.2, 3.0
"""m, m, Pa."""
CUT = {
    2: [(0, 1, 2), (0, 2, 3)],
    3: [(0, a, b, 6) for a, b in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))],
}
"""Axes -> corners of the simplices that a square or cube is cut into, by its diagonal."""
IDENTITY = 1e-12
PARTS, STEPS = 40, 6
"""Of a displacement, and Newton steps in each."""
SMALL, TOLERANCE = 1e-9, 1e-14
"""A strain, and the elements' residual over the forces at a node."""


class Pair(NamedTuple):
    """A network, its elements, and whether these are one."""

    body: str
    springs: str
    elements: str
    nu: float
    strain: float
    cells: int
    twin: bool = True


PAIRS = (
    Pair("triangles, uneven", "zero-length", "P1 neo-Hookean", 0.3, 0.8, 4),
    Pair("triangles, uneven", "zero-length", "P1 neo-Hookean", 0.3, SMALL, 4),
    Pair("triangles, uneven", "zero-length", "P1 neo-Hookean", -0.3, 0.8, 4),
    Pair("tetrahedra, uneven", "zero-length", "T1 neo-Hookean", 0.45, 0.8, 2),
    Pair("tetrahedra, even", "zero-length", "T1 neo-Hookean", 0.3, 0.8, 2),
    Pair("squares, k1 = k2", "zero-length", "Q1 neo-Hookean, mean J", 0.49, 0.8, 4),
    Pair("squares, k1 = 2 k2", "zero-length", "Q1 neo-Hookean, mean J", 0.49, 0.8, 4, False),
    Pair("quadrilaterals, uneven", "zero-length", "Q1 neo-Hookean, mean J", 0.49, 0.8, 3),
    Pair("hexahedra, uneven", "zero-length", "H1 neo-Hookean, mean J", 0.45, 0.4, 2),
    Pair("triangular lattice", "green", "P1 St. Venant-Kirchhoff", 0.25, 0.3, 4),
    Pair("squares, k1 = k2", "green", "Q1 St. Venant-Kirchhoff", 0.25, 0.3, 4, False),
)
BECAUSE = (
    "an identity, left is rounding: 1e-16 times the forces that meet at a point, and a condition "
    "number of up to 1e4"
)
twin = partial(kit.Rule, unit="1", table="twins", because=BECAUSE)
RULES = (
    twin("forces of random states, relative", 1e-13, value="force", rows={"twin": True},
         because="an identity: the rounding of sums over a point's cells"),
    twin("tangents of random states, relative", 1e-13, value="tangent", rows={"twin": True},
         because="an identity: the rounding of sums over a point's cells"),
    twin("equilibria bent to 30 to 80 % strain, over the largest displacement", IDENTITY,
         value="displacement", rows={"twin": True, "strain": (0.8, 0.3)}),
    twin("equilibria at a strain of 1e-9, over the largest displacement", 1e-6,
         value="displacement", rows={"twin": True, "strain": SMALL},
         because="terms of second order are 1e-9, and forces have ten digits or more of it"),
    kit.Rule(
        "networks that are no elements: least difference over 1e-4, up to 1", 0.5, "1",
        "other constants or springs are another discretisation, off by parts in a thousand; a "
        "comparison that calls them the same sees nothing", table="twins", rows={"twin": False},
        value=lambda rows: np.minimum(1.0, rows["displacement"] / 1e-4), reference=1.0,
    ),
)  # fmt: skip
FIGURES = {
    "twins": kit.series(
        "twins", title="Springs beside elements on the same points", x="body", y="displacement",
        by="springs", log="y", line="", size=(11.0, 3.4),
        labels=("network", "difference over largest displacement (1)"),
    ),
}  # fmt: skip


def draw_bent(tables: kit.Tables) -> Figure:
    """Springs that are elements: bodies bent to 80 % strain."""
    figure, axes = kit.figures.new_figure(2, size=(3.7, 3.2))
    for axis, (body, rows) in zip(axes, tables["bent"].groupby("body", sort=False), strict=True):
        for label, kind, colour in (
            ("springs that pull", "pull", "#0072b2"),
            ("springs that push", "push", "#d55e00"),
        ):
            ends = rows[rows["kind"] == kind].groupby("number")[["x", "y"]]
            lines = [line.to_numpy() for _, line in ends]
            if lines:
                axis.add_collection(LineCollection(lines, label=label, color=colour))
        nodes = rows[rows["kind"] == "node"]
        axis.plot(nodes["x"], nodes["y"], "o", mfc="none", color="black", label="nodes of elements")
        axis.set(xlabel="x (m)", ylabel="y (m)", title=body, aspect="equal")
    kit.figures.add_shared_legend(figure, list(axes), 3)
    figure.suptitle("Springs that are elements: bodies bent to 80 % strain")
    return figure


def bent_bodies(candidate: kit.DisplacementSolver) -> pd.DataFrame:
    """Ends of springs and nodes of elements of two twins, where they come to rest."""
    rows = []
    for pair in (PAIRS[0], PAIRS[5]):
        problem, network, elements = make_bodies(pair)
        x = network.points + candidate(problem, network, "nonlinear")
        pushes = network.stiffness < 0
        for number, ends in enumerate(network.springs):
            kind = "push" if pushes[number] else "pull"
            rows += [
                (pair.body, kind, number, *x[end]) for end in ends if network.stiffness[number]
            ]
        nodes = network.points + elements.rest(network.displacement)
        rows += [(pair.body, "node", number, *node) for number, node in enumerate(nodes)]
    return pd.DataFrame(rows, columns=["body", "kind", "number", "x", "y"])


def _spoil(
    change: Callable[[Network], Network],
    problem: kit.Problem,
    network: Network,
    answer: kit.Answer,
) -> Array:
    """What a changed network does; where it comes to no rest, as it was moved."""
    try:
        return kit.solve_springs(problem, change(network), answer)
    except kit.SolverError:
        return np.array(network.displacement)


def _without_pressure(network: Network) -> Network:
    """One cell has no pressure at rest, if any has."""
    cells = network.volumes
    if cells is None:
        return network
    pressure = np.where(np.arange(len(cells.cells)) == 0, 0.0, cells.pressure)
    return replace(network, volumes=replace(cells, pressure=pressure))


FAULTS = {
    "one cell's pressure missing": {
        "candidate": partial(_spoil, _without_pressure), "questions": ("twins",)
    },
}  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Compare networks and elements, force by force and at rest."""
    table = pd.DataFrame(setting.sweep(partial(compare, candidate), PAIRS, "twins"))
    same = table[table["twin"]]
    bent = same[same["strain"] > SMALL]["displacement"].max()
    other = table[~table["twin"]]["displacement"].min()
    same_body = (
        "With the right law a spring network is a finite element body, node for node: springs of "
        "no rest length, by cotangents, beside cells under pressure are linear elements of "
        f"the neo-Hookean law, to {bent:.0e} of the displacement at strains of 80 %; quadri"
        "laterals and hexahedra are linear elements with one mean J a cell (squares: k1 = k2)."
    )
    others = f"Other constants on the same points differ by {100 * other:.2g} % or more."
    return kit.Evidence(
        {"twins": table, "bent": bent_bodies(candidate)}, tolerances=RULES,
        columns=kit.columns(__file__), findings=(same_body, others),
        figures={"bent": draw_bent, **FIGURES},
    )  # fmt: skip


def compare(candidate: kit.DisplacementSolver, pair: Pair) -> dict[str, object]:
    """One row of the table."""
    problem, network, elements = make_bodies(pair)
    u = candidate(problem, network, "nonlinear")
    theirs = elements.rest(network.displacement)
    random = 0.02 * pair.strain * SIZE / pair.cells
    state = random * np.random.default_rng(1).normal(size=u.shape)
    at, force = Configuration(network, state), elements.force(state)
    K = at.tangent().toarray()
    bent = elements.tangent(state)
    return {
        **pair._asdict(),
        "points": len(u),
        "force": np.abs(at.force() + force).max() / np.abs(force).max(),
        "tangent": np.abs(K - bent).max() / np.abs(bent).max(),
        "displacement": np.abs(u - theirs).max() / np.abs(theirs).max(),
    }


def make_bodies(pair: Pair) -> tuple[kit.Problem, Network, _Solid | _MeanVolume]:
    """What is asked, the network, and the elements beside it."""
    solid = pair.elements[0] in "TH"
    d, n, box = (3 if solid else 2), pair.cells, kit.Box((SIZE,) * (3 if solid else 2))
    material = kit.Isotropic(
        E, pair.nu, "solid" if solid else "plane_strain", thickness=1.0 if solid else THICKNESS
    )
    grid: lattice.Lattice = (
        lattice.square(box, n) if d == 2 else lattice.fill(patterns.cubic18(), box, n)
    )
    cells, shape = np.asarray(grid.cells), "hexahedron" if solid else "quad"
    if pair.body == "triangular lattice":
        grid = lattice.triangular(lattice.zigzag_block(SIZE, (n, n)), SIZE / n)
        cells, shape = np.asarray(grid.cells), "triangle"
    elif pair.body.startswith(("triangles", "tetrahedra")):
        shape = "tetra" if solid else "triangle"
        cells = cells[:, np.array(CUT[d])].reshape(-1, d + 1)
    points = np.array(grid.points)
    if pair.body.endswith("uneven"):
        inner: kit.Mask = np.abs(points / SIZE - 0.5).max(axis=1) < 0.49
        moved = np.random.default_rng(0).uniform(-0.3, 0.3, points.shape)
        points += inner[:, None] * moved * SIZE / n
    mesh = kit.Mesh(points, cells, shape)
    ends = points[:, 0].min(), points[:, 0].max()
    far = pair.strain * SIZE * np.array([0.5, -0.3, 0.2][:d])
    low, high = (kit.Region((x, *(None,) * (d - 1))) for x in ends)
    bent = tuple(partial(_bend, by) for by in far)
    held = kit.Support(low, (0.0,) * d), kit.Support(high, bent)
    problem = kit.Problem(mesh, material, held)
    network = _make_network(pair, problem, grid, material)
    if pair.elements.endswith("mean J"):
        return problem, network, _MeanVolume(network, material)
    body = make_discretisation(points, cells, pair.elements[:2])
    law = neo_hookean if "neo-Hookean" in pair.elements else st_venant_kirchhoff
    return problem, network, _Solid(Solid(body, law(material), network.fixed, material.thickness))


def _bend(by: float, X: kit.Array) -> kit.Array:
    """Displacement (n,) in m of a side's points (n, d): `by` at its foot, more above."""
    return np.asarray(by * (1 + X[:, 1] / SIZE))


def _make_network(
    pair: Pair, problem: kit.Problem, grid: lattice.Lattice, material: kit.Isotropic
) -> Network:
    if pair.springs == "green":
        own = replace(problem, domain=grid.domain) if grid.domain != problem.domain else problem
        network = lattice_network(own, grid, (1.0,) if grid.kinds == 1 else (1.0, 1.0))
        return replace(network, stiffness=network.stiffness * _green(material), law=GREEN)
    if pair.body.startswith("squares"):
        found = calibrate_material(material, grid, route="neo-Hookean")
        k = found.constants[0]
        constants = (k, k) if pair.twin else (1.5 * k, 0.75 * k)
        own = replace(problem, domain=grid.domain)
        return lattice_network(own, grid, replace(found, constants=constants))
    assert isinstance(problem.domain, kit.Mesh)  # noqa: S101  as `make_bodies` has it
    edges = lattice.mesh_lattice(problem.domain, "cotangent", positive=False)
    return lattice_network(problem, edges, calibrate_material(material, edges, route="neo-Hookean"))


def _green(material: kit.Isotropic) -> float:
    """Stiffness (N/m) that makes triangles of Green's springs λ = μ: 4/√3·μt."""
    return float(4 / np.sqrt(3)) * material.E / (2 * (1 + material.nu)) * material.thickness


class _Solid(NamedTuple):
    """Elements of `reference_fem`."""

    solid: Solid

    def force(self, u: kit.Array) -> kit.Array:
        """(n, d) in N."""
        return self.solid.internal_force(u)[0]

    def tangent(self, u: kit.Array) -> kit.Array:
        """(n·d, n·d) in N/m, by points."""
        n, d = u.shape
        order = np.arange(n * d).reshape(d, n).T.ravel()
        return np.asarray(self.solid.tangent(u).toarray()[np.ix_(order, order)])

    def rest(self, moved: kit.Array) -> kit.Array:
        """Equilibrium (n, d) in m under prescribed displacements (n, d)."""
        none = np.zeros(moved.shape)
        return deform(self.solid, moved, none, tolerance=TOLERANCE, allow_locked=True).displacement


class _MeanVolume:
    """Bi- or trilinear cells of the neo-Hookean law with one mean J each, by scikit-fem.

    ∫ (μ/2) F:F is a Laplacian of each component; the volume of a cell is ∫ det F by Gauss's rule.
    """

    def __init__(self, network: Network, material: kit.Isotropic) -> None:
        X, cells = network.points, network.resisting
        E, nu, t, d = material.E, material.nu, material.thickness, network.dim
        self.X, self.cells, self.held = X, cells, network.fixed
        self.mu, self.lam = E / (2 * (1 + nu)) * t, E * nu / (1 + nu) / (1 - 2 * nu) * t
        element = skfem.ElementQuad1() if d == 2 else skfem.ElementHex1()
        # Where scikit-fem has each corner of VTK's list: hexahedra are numbered in another way.
        unit = np.array(SHAPES["quad" if d == 2 else "hexahedron"].nodes)
        own = np.abs(unit[:, None] - element.doflocs[None]).sum(axis=2).argmin(axis=0)
        kind = skfem.MeshQuad if d == 2 else skfem.MeshHex
        basis = skfem.Basis(kind(X.T.copy(), cells[:, own].T.copy()), element, intorder=3)
        A = self.mu * laplace.assemble(basis)
        at = np.empty(len(X), dtype=int)
        at[basis.nodal_dofs[0]] = np.arange(len(X))
        self.K = kron(A[basis.nodal_dofs[0]][:, basis.nodal_dofs[0]], np.eye(d)).tocsr()
        self.weights = basis.W
        slopes = [element.lbasis(basis.X, i)[1] for i in range(len(own))]
        self.slopes = np.stack(slopes).transpose(2, 0, 1)[:, np.argsort(own, kind="stable")]
        self.V0 = self._volumes(X[cells])[0]

    def _volumes(self, x: kit.Array) -> tuple[kit.Array, kit.Array]:
        """Volumes (c,) of cells with corners (c, k, d), and their slopes (c, k, d)."""
        F = np.einsum("qke,ckx->cqxe", self.slopes, x)
        J = np.linalg.det(F) * self.weights
        return J.sum(axis=1), np.einsum("cq,qke,cqex->ckx", J, self.slopes, np.linalg.inv(F))

    def force(self, u: kit.Array) -> kit.Array:
        """(n, d) in N."""
        V, g = self._volumes((self.X + u)[self.cells])
        J = V / self.V0
        out = np.asarray((self.K @ (self.X + u).ravel()).reshape(u.shape))
        np.add.at(out, self.cells, ((self.lam * np.log(J) - self.mu) / J)[:, None, None] * g)
        return out

    def tangent(self, u: kit.Array) -> kit.Array:
        """(n·d, n·d) in N/m, by points; of slopes, of degree 2 at most, differences are exact."""
        d, (V, g), k = u.shape[1], self._volumes((self.X + u)[self.cells]), self.cells.shape[1]
        J = V / self.V0
        slope = (self.lam * np.log(J) - self.mu) / J
        bend = (self.lam + self.mu - self.lam * np.log(J)) / J**2 / self.V0
        dof = d * self.cells[:, :, None] + np.arange(d)
        K, size = np.asarray(self.K.toarray()), SIZE / len(J)
        for corner in range(k):
            for axis in range(d):
                block = (bend * g[:, corner, axis])[:, None, None] * g
                ends = []
                for way in (size, -size):
                    x = (self.X + u)[self.cells]
                    x[:, corner, axis] += way
                    ends.append(self._volumes(x)[1])
                block += slope[:, None, None] * (ends[0] - ends[1]) / (2 * size)
                np.add.at(K, (dof, dof[:, corner, axis][:, None, None]), block)
        return K

    def rest(self, moved: kit.Array) -> kit.Array:
        """Equilibrium (n, d) in m under prescribed displacements (n, d), by Newton's method."""
        free, u = ~self.held.ravel(), np.zeros(moved.shape)
        for _ in range(PARTS):
            u[self.held] += moved[self.held] / PARTS
            for _ in range(STEPS):
                step = np.zeros(u.size)
                K = self.tangent(u)[np.ix_(free, free)]
                step[free] = np.linalg.solve(K, -self.force(u).ravel()[free])
                u += step.reshape(u.shape)
        return np.where(self.held, moved, u)
