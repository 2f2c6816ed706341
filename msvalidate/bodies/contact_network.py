"""From a `Problem` with contacts to a network and the points that may touch."""

from __future__ import annotations

from typing import Any

import numpy as np

from msvalidate.bodies.lattice_network import lattice_network, side_force
from msvalidate.lattice import CutLattice, Lattice, VoronoiLattice
from msvalidate.network import Network
from msvalidate.problem import Contact, Problem, ProblemError, Traction
from msvalidate.problem.records import replace
from msvalidate.statics.contact import Touching


def contact_network(
    problem: Problem, lattice: Lattice, *given: Any, **named: Any
) -> tuple[Network, tuple[Touching, ...]]:
    """Network of a problem, and for each of its contacts the points that may touch.

    Parameters
    ----------
    problem, lattice
        As for `lattice_network`, which gets what else is given.

    Raises
    ------
    ProblemError
        As `lattice_network`, or if the points of the lattice are not where the surface is, or none
        is on the part that may touch, or the centre of a disc or ball is in the body.
    """
    touching = touching_points(problem, lattice)
    return lattice_network(replace(problem, contacts=()), lattice, *given, **named), touching


def touching_points(problem: Problem, lattice: Lattice) -> tuple[Touching, ...]:
    """For each contact of a problem the lattice's points that may touch; errors as above."""
    if isinstance(lattice, CutLattice | VoronoiLattice):
        raise ProblemError(
            f"contact: points of the {lattice.name} lattice are not where the surface is; take a "
            "lattice that fills a box, or the edges of a mesh"
        )
    return tuple(_touching(problem, lattice, contact) for contact in problem.contacts)


def _touching(problem: Problem, lattice: Lattice, contact: Contact) -> Touching:
    """Points (c,) that have a share of the part of the surface that may touch."""
    one = np.eye(lattice.points.shape[1])[0]
    area = side_force(Traction(contact.region, tuple(one)), lattice)[:, 0]
    points = np.flatnonzero(area > 0)
    share = problem.material.thickness * area[points]
    return Touching(points, share, contact.obstacle, contact.depth, contact.force, contact.friction)
