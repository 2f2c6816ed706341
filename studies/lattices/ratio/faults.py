"""Faults of volumes: which does the study notice, and how small may they be?

Question   The smallest wrong part of κ, of every cell or of one, that a tolerance notices.
Candidate  Stretched and bent blocks whose network has a known fault.
Reference  The tolerances of `stretch`; deflections of the right network.
Expected   Identities notice parts in 1e8 where κ is of the size of μ. Near 1/2 they notice less: a
           ratio that is 1/2 but for a thousandth changes by a thousandth of what κ does. For the
           same reason a bent block hardly feels κ: no fault of κ is looked for there, but faults
           of its springs, and of how many volumes it has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate.judging.candidate import Answer, DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.network import Network
from msvalidate.network.faults import stiffen_all
from msvalidate.network.laws.volumes import Volumes
from msvalidate.problem import Array, Problem

from . import bent, stretch
from .bent import Bent
from .stretch import Block

PROBE = 1e-3
"""Size of the fault, either way, from which the smallest that is noticed is extrapolated: what it
changes is then 1e5 times the rounding of `stretch`, and its square cancels in the mean."""
ONE_PER_CENT = 0.01
BLOCKS = (
    Block("square", "plane_stress", 0.45),
    Block("square", "plane_strain", 0.499),
    Block("triangular", "plane_strain", 0.45),
    Block("cubic18", "solid", 0.4),
    Block("cubic18", "solid", 0.49),
)
TOLERANCES = (
    Tolerance(
        "smallest fault of κ noticed, largest over blocks and kinds", 1e-5, "1",
        "ten thousand times the limit of an identity: a ratio near 1/2 is a thousandth as "
        "sensitive to κ, one cell of 25 a tenth as all",
    ),
)  # fmt: skip
COLUMNS = {
    "block": "lattice, state and Poisson's ratio of the stretched or bent block",
    "fault_of_volumes": "whose κ is wrong: every cell's, or that of one in the middle",
    "smallest_part": "smallest part of κ that makes a tolerance of stretched blocks fail (1)",
    "deflection_by_1_percent": "change of a bent block's deflection if the κ of all cells is wrong "
    "by 1 %, relative, at 8 cells (1)",
}


def every_volume(network: Network, size: float) -> Network:
    """The κ of every cell larger by the fraction `size`."""
    return _scaled(network, lambda kappa: kappa * (1 + size))


def one_volume(network: Network, size: float) -> Network:
    """The cell in the middle of the list without the part `size` of its κ."""

    def less(kappa: Array) -> Array:
        factor = np.ones(len(kappa))
        factor[len(factor) // 2] -= size
        return kappa * factor

    return _scaled(network, less)


def halved_cells(network: Network, size: float) -> Network:
    """Two triangles with a volume each instead of every quadrilateral, whatever the size."""
    volumes = network.volumes
    squares = volumes is not None and volumes.dim == 2 and volumes.cells.shape[1] == 4
    return bent.split(network) if squares else network


def _scaled(network: Network, change: Callable[[Array], Array]) -> Network:
    volumes = network.volumes
    if volumes is None:
        return network
    kappa = change(np.array(volumes.stiffness))
    return replace(network, volumes=Volumes(volumes.points, volumes.cells, kappa))


KINDS = {"every cell": every_volume, "one cell": one_volume}


def apply_fault(
    fault: Callable[[Network, float], Network],
    size: float,
    problem: Problem,
    network: Network,
    answer: Answer = "linear",
) -> Array:
    """A candidate whose network has a fault."""
    return solve_springs(problem, fault(network, size), answer)


def with_fault(fault: Callable[[Network, float], Network], size: float) -> DisplacementSolver:
    """The spring network with a fault of some size."""
    return partial(apply_fault, fault, size)


FAULTS = {
    "kappa 1 % too large": {
        "candidate": with_fault(every_volume, ONE_PER_CENT),
        "questions": ("any_ratio",),
    },
    "the kappa of one cell missing": {
        "candidate": with_fault(one_volume, 1.0),
        "questions": ("any_ratio",),
    },
    "a volume for each half of a cell": {
        "candidate": with_fault(halved_cells, 1.0),
        "questions": ("rubber",),
    },
    "bent blocks 1 % stiffer": {
        "candidate": with_fault(stiffen_all, ONE_PER_CENT),
        "questions": ("rubber",),
    },
}
"""Negative controls: arguments of the study's `run` under which a tolerance must fail."""


def run(setting: Setting) -> Evidence:
    """State the smallest fault of κ that is noticed, and what a bent block feels of it."""
    rows = [
        {
            "block": _describe(block),
            "fault_of_volumes": kind,
            "smallest_part": smallest(block, fault),
        }
        for block in BLOCKS
        for kind, fault in KINDS.items()
    ]
    felt = pd.DataFrame(setting.sweep(deflection_row, (0.45, 0.499), "faults of bent blocks"))
    table = pd.DataFrame(rows)
    least, most = table["smallest_part"].min(), table["smallest_part"].max()
    near, nearest = felt["deflection_by_1_percent"].abs()
    said = (
        f"Stretched blocks notice κ wrong by {least:.1g} to {most:.1g}. A bent block feels little "
        f"of it: 1 % of κ changes its deflection by {near:.1g} at nu = 0.45 and {nearest:.1g} at "
        "0.499."
    )
    return Evidence(
        tables={"volume_faults": table, "volume_faults_bent": felt},
        observed={TOLERANCES[0].quantity: farthest_value(table["smallest_part"], 0.0)},
        tolerances=TOLERANCES,
        columns=COLUMNS,
        rounding={"deflection_by_1_percent": 1e-9},
        findings=(said,),
    )


def smallest(block: Block, fault: Callable[[Network, float], Network]) -> float:
    """Smallest size of a fault that a stretched block notices."""
    seen = [_is_noticed(block, with_fault(fault, size)) for size in (PROBE, -PROBE)]
    return PROBE * stretch.EXACT / (sum(seen) / len(seen))


def _is_noticed(block: Block, candidate: DisplacementSolver) -> float:
    """Largest error of those that the tolerances of `stretch` judge."""
    row = stretch.measure(candidate, block)
    return max(
        abs(float(str(row["nu_found"])) - block.nu),
        abs(float(str(row["E_found"])) - 1),
        float(str(row["displacement_error"])),
    )


def deflection_row(nu: float) -> dict[str, object]:
    """One row of the table `volume_faults_bent`."""
    block = Bent("plane_strain", nu, "square", 8)
    right = bent.deflection(solve_springs, block)
    wrong = bent.deflection(with_fault(every_volume, ONE_PER_CENT), block)
    name = f"square, plane strain, {nu:g}"
    return {"block": name, "deflection_by_1_percent": wrong / right - 1}


def _describe(block: Block) -> str:
    return f"{block.lattice}, {block.state.replace('_', ' ')}, {block.nu:g}"
