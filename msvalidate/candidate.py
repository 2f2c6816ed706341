"""Floor 2: what a study judges: a way to predict displacements; by default the spring network."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

from msvalidate.equilibrium import equilibrium
from msvalidate.network import Network
from msvalidate.problem import Array, Problem, chosen
from msvalidate.viscous import algorithm1

AT_REST = 3e-11
"""Residual over the forces that meet at a point: a slow mode makes up to a hundred times as much
relative displacement of it."""
Answer = Literal["linear", "nonlinear", "relaxed"]
"""Static equilibrium to first order, or in full, or where Algorithm 1 comes to rest."""
Candidate = Callable[[Problem, Network, Answer], Array]
"""Predicts the displacement (n, d) in m at a network's points, from the problem or the network."""


def springs(problem: Problem, network: Network, answer: Answer = "linear") -> Array:  # noqa: ARG001
    """The spring network's own answer.

    Raises
    ------
    ProblemError
        If there is no such answer, or no network.
    SolverError
        If there is no trustworthy answer.
    """
    chosen("answer", answer, get_args(Answer))
    if answer == "relaxed":
        return algorithm1(network, tolerance=AT_REST).equilibrium.displacement
    return equilibrium(network, answer).displacement
