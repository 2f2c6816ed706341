# SPDX-License-Identifier: MIT
"""Which simulators are judged, with which laws and settings, and which are not, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from simulators.sweep import EQUAL, Sweep

SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"
SPLIT = "neo-Hookean of shape and volume apart"
SIMPLE = "neo-Hookean without logarithm, Lamé's constants as they stand"
VOLUMETRIC = "neo-Hookean without logarithm, lam + mu"
CONSTRAINTS = "two constraints, I - 3 and J - 1"
STVK = "Saint Venant-Kirchhoff"
LAME_4409 = "bulletphysics/bullet3#4409 (open in a copy, 2026-11-24): what mu and lambda mean"
HOW_4520 = "bulletphysics/bullet3#4520 (open in a copy, 2026-11-24): how accurate its FEM is"
MASSES_2901 = (
    "newton-physics/newton#2901 (open in a copy, 2026-11-24): tests of VBD's neo-Hookean "
    "law, whose lambda is lambda + mu; its grid helper puts a full cell's mass on every node"
)
XPBD_49 = "newton-physics/newton#49 (open in a copy, 2026-11-24): tetrahedra collapse under XPBD"
XPBD_2933 = (
    "newton-physics/newton#2933 (open in a copy, 2026-11-24): multipliers of XPBD's "
    "constraints are lost between iterations; in the source of 1.8.0 those of tetrahedra are kept"
)


@dataclass(frozen=True)
class Job:
    """A simulator with one law.

    Parameters
    ----------
    name
        Of the file of results.
    adapter
        File in adapters/.
    environment
        `.venv-NAME` that it runs in; "" for our own.
    law
        Of `msvalidate.simulators.laws`, as its documents or source have it; "" if it has none.
    source
        Where that stands.
    settings, probed
        Of the simulator, and of the probe's steps beside.
    weighed
        Settings with which masses are measured, where those of the law are too loose for that.
    converged
        Settings at which its bodies are at rest, where those above do not bring them so far: what
        is between the two is the cause "solver".
    curve
        Whether the probe alone is asked at all of `CURVE` too.
    draft
        Whether its author has still to be told.
    upstream
        Known issues, their state and when that was looked at; copies of the web may be older.
    sweeps
        Rest states at several dt and iterations.
    one_cell
        Whether it puts a body into one trilinear cell, by design.
    masses
        Whose its nodes have, as documented, where the probe measures none: it answers by forces.
    """

    name: str
    adapter: str
    environment: str
    law: str
    source: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    probed: Mapping[str, Any] = field(default_factory=dict)
    curve: bool = False
    weighed: Mapping[str, Any] | None = None
    draft: bool = True
    upstream: tuple[str, ...] = ()
    converged: Mapping[str, Any] | None = None
    sweeps: tuple[Sweep, ...] = ()
    program: str = ""
    masses: str = ""
    one_cell: bool = False


JOBS = (
    Job(
        "calculix", "calculix.py", "", "linear", "ccx manual, *ELASTIC", draft=False, program="ccx"
    ),
    Job(
        "calculix-stiffer", "calculix.py", "", "", "control: E times 1.01",
        {"stiffer": 1.01}, draft=False, program="ccx",
    ),
    Job(
        "ngsolve-1", "ngsolve.py", "ngsolve", "linear", "the adapter's own form",
        {"order": 1}, draft=False,
    ),
    Job("felupe-linear", "felupe.py", "felupe", "linear", "felupe.LinearElastic",
        {"law": "linear"}, draft=False),
    Job("felupe-neo_hooke", "felupe.py", "felupe", SPLIT, "felupe.NeoHooke",
        {"law": "neo_hooke"}, draft=False),
    Job("drake-linear", "drake.py", "drake", "linear", "linear_constitutive_model.cc:52",
        {"law": "linear"}),
    Job("drake-linear_corotated", "drake.py", "drake", "corotated",
        "linear_corotated_model.cc:51 (shipped default)", {"law": "linear_corotated"}, curve=True,
        sweeps=(Sweep(law="corotated"),)),
    Job("drake-corotated", "drake.py", "drake", "fixed corotated", "corotated_model.cc:42",
        {"law": "corotated"}),
    Job("drake-neo_hookean", "drake.py", "drake", SIMPLE, "neohookean_model.cc:42-45",
        {"law": "neo_hookean"}, curve=True, weighed={"law": "linear"}),
    Job("mujoco-stvk", "mujoco.py", "mujoco", "Saint Venant-Kirchhoff",
        "manual, XMLreference, flexcomp elasticity", {"law": "stvk"},
        sweeps=(
            Sweep(law=STVK, masses=EQUAL, label="Euler"),
            Sweep((0.02, 0.01), (3, 6, 12, 25, 50, 100, 200, 400), STVK, EQUAL,
                  {"integrator": "discrete", "tolerance": 1e-12}, "discrete"),
        )),
    Job("mujoco-stvk-asked_masses", "mujoco.py", "mujoco", "Saint Venant-Kirchhoff",
        "manual, XMLreference, flexcomp elasticity", {"law": "stvk", "masses": "asked"}),
    Job("mujoco-discrete", "mujoco.py", "mujoco", "Saint Venant-Kirchhoff",
        "manual, XMLreference, flexcomp elasticity", {"law": "stvk", "integrator": "discrete"}),
    Job("mujoco-snh", "mujoco.py", "mujoco", "", "manual, APItypes, mjsFlex: no formula there",
        {"law": "snh", "integrator": "discrete"}),
    Job("mujoco-trilinear", "mujoco.py", "mujoco", "corotated",
        "one cell by design; manual, XMLreference, flexcomp dof; changelog of 4.0",
        {"dof": "trilinear"}, masses="an eighth of the box on each of its corners",
        one_cell=True),
    Job("newton-semi", "newton.py", "newton", SMITH,
        "semi_implicit/kernels_particle.py:296, 317, 412", {"solver": "semi"},
        sweeps=(Sweep(law=SMITH),)),
    Job("newton-vbd", "newton.py", "newton", VOLUMETRIC,
        "vbd/particle_vbd_kernels.py:228-250", {"solver": "vbd", "iterations": 10, "dt": 1e-3},
        {"iterations": 200}, converged={"iterations": 40, "dt": 5e-4},
        upstream=(MASSES_2901,),
        sweeps=(Sweep((8e-3, 4e-3, 2e-3), (10, 20, 40, 80), VOLUMETRIC),)),
    Job("newton-xpbd", "newton.py", "newton", CONSTRAINTS,
        "xpbd/kernels.py:593-602; all tetrahedra's corrections are summed, and velocities clipped "
        "where that diverges (:865-874), at .5 ms by 20 iterations of a jittered block",
        {"solver": "xpbd", "iterations": 2, "dt": 5e-4, "limit": 6000},
        upstream=(XPBD_49, XPBD_2933),
        sweeps=(Sweep((5e-4, 2.5e-4, 1.25e-4), (2, 4, 8), CONSTRAINTS),)),
    Job("pybullet-neo_hookean", "pybullet.py", "pybullet", SMITH,
        "btDeformableNeoHookeanForce.h:358-363", {"dt": 5e-5}, upstream=(LAME_4409, HOW_4520),
        sweeps=(Sweep((5e-5, 2.5e-5), law=SMITH, masses=EQUAL),)),
)  # fmt: skip


@dataclass(frozen=True)
class Excluded:
    """What is not run.

    Parameters
    ----------
    simulator, law
        What it is; law or settings, "" for all of it.
    permanent
        Whether it stays so; else work is to do.
    because
        Why.
    """

    simulator: str
    law: str
    permanent: bool
    because: str


EXCLUDED = (
    Excluded("any whose licence has a clause on benchmarks", "", True,
             "what is found could not be published"),
    Excluded("PyBullet", "springs along edges", True,
             "it is given spring constants: no E and no ratio is asked for"),
    Excluded("MuJoCo", "flexes in the plane and rods", True,
             "shells and rods, not solids: what is asked for here are bodies in space"),
    Excluded("MuJoCo", "dof quadratic", False,
             "one cell of 27 nodes: the adapter puts bodies into full and trilinear ones alone"),
    Excluded("PhysX", "deformable volumes", False,
             "they run on a GPU alone, by its documentation, and records are made without one"),
    Excluded("SOFA", "", False,
             "no wheel: environments here are pinned wheels with checksums; no adapter yet"),
    Excluded("Genesis", "", False,
             "its packages could not be resolved for an environment in 2026; no adapter yet"),
)  # fmt: skip
"""What is not run, and why; in the study's table beside what is."""
