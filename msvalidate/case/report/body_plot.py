"""Plots of problems, networks and results, drawn over each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msvalidate.bench.output.body_drawing import Drawing, network_drawing, overlay_drawings
from msvalidate.case.report.outlines import outline_edges
from msvalidate.problem import Problem, ProblemError, prescribed_displacements
from msvalidate.problem.checks import format_value
from msvalidate.problem.records import replace
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.dynamics.run import Relaxation
from msvalidate.springs.lattice import CutLattice, Lattice
from msvalidate.springs.network import Network
from msvalidate.springs.statics.equilibrium import Equilibrium
from reference_fem.body import nodal_forces
from reference_fem.first_mesh import first_mesh
from reference_fem.mesh.discretisation import Discretisation

STATES = (np.ndarray, State, Equilibrium, Relaxation)
"""Types of results that belong to the network before them."""


def plot(*results: Any, magnification: float | None = None) -> Figure:
    """Plot bodies in their reference and deformed positions, in one pair of axes.

    Parameters
    ----------
    results
        Problem, lattice, network, solution, comparison or relaxation; several are drawn over each
        other. A displacement (m) of shape (n, d), a `State` or an ``Equilibrium`` belongs to the
        network before it.
    magnification
        Factor of the displacements, > 0. Default: 1, 2 or 5 times a power of ten, so that the
        largest displacement appears as at most a tenth of the body; 1 if it is between a tenth of
        the body and all of it.

    Returns
    -------
    matplotlib.figure.Figure
        Figure whose title states the magnification.

    Raises
    ------
    ProblemError
        If there is nothing to plot, a displacement does not fit the network, or the magnification
        is not positive.

    Examples
    --------
    >>> from msvalidate import plot, spring_network
    >>> points = [[0.0, 0.0], [0.37, 0.0], [0.0, 0.2]]  # m
    >>> network = spring_network(points, [[0, 1], [1, 2], [2, 0]], stiffness=100.0)
    >>> figure = plot(network)  # figure.savefig("network.png") writes a file
    >>> len(figure.axes)
    1
    """
    drawings: list[Drawing] = []
    network: Network | None = None
    for result in results:
        if network is not None and isinstance(result, STATES):
            move = getattr(result, "displacement", result)
            move = result.position - network.points if isinstance(result, State) else move
            drawings += network_drawings(network, move)
            network = None
            continue
        drawings += [] if network is None else network_drawings(network)
        network = result if isinstance(result, Network) else None
        drawings += [] if network is not None else _drawings_of(result)
    drawings += [] if network is None else network_drawings(network)
    labels = [each.label for each in drawings]
    drawings = [
        each._replace(label=f"{each.label} {1 + labels[:i].count(each.label)}")
        if labels.count(each.label) > 1
        else each
        for i, each in enumerate(drawings)
    ]
    if not drawings:
        raise ProblemError("plot: nothing to plot; give a problem, a network or a solution")
    if len({each.points.shape[1] for each in drawings}) > 1:
        raise ProblemError("plot: bodies in 2D and in 3D; plot them one by one")
    return overlay_drawings(drawings, magnification)


def mesh_drawing(problem: Problem, mesh: Discretisation | None = None) -> Drawing:
    """Return the outline of a problem's body, with supports and loads on a mesh."""
    mesh = mesh or first_mesh(problem)
    fixed, _ = prescribed_displacements(problem, mesh.points)
    loads = nodal_forces(replace(problem, contacts=()), mesh)
    return Drawing("body", mesh.points, outline_edges(mesh), None, fixed, loads)


def network_drawings(network: Network, displacement: Any = None) -> list[Drawing]:
    """Springs, and the outline of the body that a cut lattice does not follow."""
    springs, body = network_drawing(network, displacement), network.body
    if body is None or not isinstance(body.lattice, CutLattice):
        return [springs]
    return [springs, mesh_drawing(body.problem)]


def _drawings_of(result: Any) -> list[Drawing]:
    """Drawings of a result; raises `ProblemError` for an object that has none."""
    drawings: list[Drawing] | None = getattr(result, "drawings", None)
    if drawings is not None:
        return drawings
    if isinstance(result, Relaxation):
        return network_drawings(result.network, result.displacement)
    if isinstance(result, Problem):
        return [mesh_drawing(result)]
    if isinstance(result, Lattice):
        zero = np.zeros(result.points.shape)
        return [Drawing("springs", result.points, result.springs, None, zero > 0, zero)]
    raise ProblemError(
        f"plot: {format_value(result)}; give a problem, lattice, network, solution, comparison or "
        "relaxation, or a network with its equilibrium: plot(network, equilibrium)"
    )
