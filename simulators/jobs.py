# SPDX-License-Identifier: MIT
"""Which simulators are judged, with which laws and settings, and which are not, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"
SPLIT = "neo-Hookean of shape and volume apart"
SIMPLE = "neo-Hookean without logarithm, Lamé's constants as they stand"


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
    curve
        Whether the probe alone is asked at all of `CURVE` too.
    draft
        Whether its author has still to be told.
    upstream
        Known issues, their state and when that was looked at.
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
        "linear_corotated_model.cc:51 (shipped default)", {"law": "linear_corotated"}, curve=True),
    Job("drake-corotated", "drake.py", "drake", "fixed corotated", "corotated_model.cc:42",
        {"law": "corotated"}),
    Job("drake-neo_hookean", "drake.py", "drake", SIMPLE, "neohookean_model.cc:42-45",
        {"law": "neo_hookean"}, curve=True, weighed={"law": "linear"}),
    Job("mujoco-stvk", "mujoco.py", "mujoco", "Saint Venant-Kirchhoff",
        "manual, XMLreference, flexcomp elasticity", {"law": "stvk"}),
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
        "semi_implicit/kernels_particle.py:296, 317, 412", {"solver": "semi"}),
    Job("newton-vbd", "newton.py", "newton", "neo-Hookean without logarithm, lam + mu",
        "vbd/particle_vbd_kernels.py:228-250", {"solver": "vbd", "iterations": 40, "dt": 2e-4},
        {"iterations": 200}),
    Job("pybullet-neo_hookean", "pybullet.py", "pybullet", SMITH,
        "btDeformableNeoHookeanForce.h:358-363"),
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
