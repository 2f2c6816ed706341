"""Faults of volumes: which does the study notice, and how small may they be?

Question   The smallest wrong part of κ, of every cell or of one, that a tolerance notices.
Candidate  Stretched blocks whose network has a known fault.
Reference  The tolerances of `stretch`.
Expected   Identities notice parts in 1e8 where κ is of the size of μ. Near 1/2 they notice less: a
           ratio that is 1/2 but for a thousandth changes by a thousandth of what κ does. For the
           same reason a bent block hardly feels κ: faults of its springs are tried there, and of
           how many volumes it has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.network.faults import stiffen_all
from msvalidate.springs.network.laws.volumes import Volumes

from . import bent, stretch
from .stretch import Block

PROBE = 1e-3
"""Size of the fault, either way, from which the smallest that is noticed is extrapolated: what it
changes is then 1e5 times the rounding of `stretch`, and its square cancels in the mean."""
BLOCKS = (
    Block("square", "plane_stress", 0.45),
    Block("square", "plane_strain", 0.499),
    Block("triangular", "plane_strain", 0.45),
    Block("cubic18", "solid", 0.4),
    Block("cubic18", "solid", 0.49),
)
RULES = (
    kit.Rule(
        "smallest fault of κ noticed, largest over blocks and kinds", 1e-5, "1",
        "ten thousand times the limit of an identity: a ratio near 1/2 is a thousandth as "
        "sensitive to κ, one cell of 25 a tenth as all",
        table="volume_faults", value="smallest_part",
    ),
)  # fmt: skip


def every_volume(network: kit.Network, size: float) -> kit.Network:
    """The κ of every cell larger by the fraction `size`."""
    return _scaled(network, slice(None), 1 + size)


def one_volume(network: kit.Network, size: float) -> kit.Network:
    """The cell in the middle of the list without the part `size` of its κ."""
    middle = len(network.volumes.cells) // 2 if network.volumes else 0
    return _scaled(network, slice(middle, middle + 1), 1 - size)


def halved_cells(network: kit.Network, size: float) -> kit.Network:
    """Two triangles with a volume each instead of every quadrilateral, whatever the size."""
    volumes = network.volumes
    squares = volumes is not None and volumes.dim == 2 and volumes.cells.shape[1] == 4
    return bent.split(network) if squares else network


def _scaled(network: kit.Network, where: slice, factor: float) -> kit.Network:
    volumes = network.volumes
    if volumes is None:
        return network
    kappa = np.array(volumes.stiffness)
    kappa[where] *= factor
    return replace(network, volumes=Volumes(volumes.points, volumes.cells, kappa))


KINDS = {"every cell": every_volume, "one cell": one_volume}


def apply_fault(
    fault: Callable[[kit.Network, float], kit.Network],
    size: float,
    problem: kit.Problem,
    network: kit.Network,
    answer: kit.Answer = "linear",
) -> kit.Array:
    """A candidate whose network has a fault."""
    return kit.solve_springs(problem, fault(network, size), answer)


def with_fault(
    fault: Callable[[kit.Network, float], kit.Network], size: float
) -> kit.DisplacementSolver:
    """The spring network with a fault of some size."""
    return partial(apply_fault, fault, size)


FAULTS = {
    name: {"candidate": with_fault(fault, size), "questions": (question,)}
    for name, fault, size, question in (
        ("kappa 1 % too large", every_volume, 0.01, "any_ratio"),
        ("the kappa of one cell missing", one_volume, 1.0, "any_ratio"),
        ("a volume for each half of a cell", halved_cells, 1.0, "rubber"),
        ("bent blocks 1 % stiffer", stiffen_all, 0.01, "rubber"),
    )
}
"""Negative controls: arguments of the study's `run` under which a tolerance must fail."""


def run() -> kit.Evidence:
    """State the smallest fault of κ that is noticed."""
    table = pd.DataFrame(
        {
            "block": f"{block.lattice}, {block.state.replace('_', ' ')}, {block.nu:g}",
            "fault_of_volumes": kind,
            "smallest_part": smallest(block, fault),
        }
        for block in BLOCKS
        for kind, fault in KINDS.items()
    )
    least, most = table["smallest_part"].min(), table["smallest_part"].max()
    return kit.Evidence(
        {"volume_faults": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(f"Stretched blocks notice κ wrong by {least:.1g} to {most:.1g}.",),
    )


def smallest(block: Block, fault: Callable[[kit.Network, float], kit.Network]) -> float:
    """Smallest size of a fault that a stretched block notices, by the rules of `stretch`."""
    rows = pd.DataFrame(stretch.measure(with_fault(fault, s), block) for s in (PROBE, -PROBE))
    nu, E = rows["nu_found"] - rows["nu_asked"], rows["E_found"] - 1
    errors = np.abs(np.array([nu, E, rows["displacement_error"]]))
    return float(PROBE * stretch.EXACT / errors.max(axis=0).mean())
