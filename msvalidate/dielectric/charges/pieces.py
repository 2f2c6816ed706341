"""What a charge is spread over: a spring, or the halves of the springs that meet at a node."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import sparse

from msvalidate.dielectric.charges.electrodes import Electrodes
from msvalidate.problem import Index
from msvalidate.problem.records import dataclass

Place = Literal["springs", "nodes"]
PLACES: tuple[Place, ...] = ("springs", "nodes")


@dataclass(frozen=True, eq=False)
class Pieces:
    """Straight pieces of even charge that make up the unknown charges, and places of these.

    Parameters
    ----------
    joints
        (e, n) sparse: the electrodes' n points and the springs' middles, as sums of these points.
    ends
        (p, 2) joints that each piece ends at.
    owner
        (p,) the charge that each piece carries a part of, in proportion to its length.
    charge_joint
        (k,) joints at which charges have their potential prescribed, and act as points.
    electrode
        (k,) which electrode each charge belongs to.
    """

    joints: sparse.csr_array
    ends: Index
    owner: Index
    charge_joint: Index
    electrode: Index


def pieces(electrodes: Electrodes, charges_on: Place) -> Pieces:
    """Whole springs, or halves of springs gathered at their nodes."""
    segments, n, m = electrodes.segments, len(electrodes.points), len(electrodes.segments)
    rows, middle = np.repeat(np.arange(m), 2), n + np.arange(m)
    middles = sparse.coo_array((np.full(2 * m, 0.5), (rows, segments.ravel())), shape=(m, n))
    joints = sparse.csr_array(sparse.vstack([sparse.eye_array(n), middles]))
    if charges_on == "springs":
        return Pieces(joints, segments, np.arange(m), middle, electrodes.electrode)
    nodes, number = np.unique(segments, return_inverse=True)
    first, last = number.reshape(segments.shape).T
    ends = np.concatenate(
        [np.column_stack([segments[:, 0], middle]), np.column_stack([middle, segments[:, 1]])]
    )
    electrode = np.empty(len(nodes), dtype=np.intp)
    electrode[first] = electrode[last] = electrodes.electrode
    return Pieces(joints, ends, np.concatenate([first, last]), nodes, electrode)
