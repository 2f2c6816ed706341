"""Validation of spring networks against elasticity theory and independent finite elements.

What most users need is offered here by name, ``from msvalidate import Box, equilibrium``; the
packages hold the rest. A name is imported when it is first used, as ``python -m msvalidate --help``
must not wait for numpy.
"""

from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"

_HOMES = {
    "springs.bodies.calibrate": ("calibrate",),
    "springs.bodies.cut_network": ("cut_network",),
    "springs.bodies.fit": ("fitted_constants",),
    "springs.bodies.lattice_network": ("lattice_network",),
    "springs.bodies.mesh_file": ("read_mesh",),
    "case.file.building": ("read_case",),
    "case.file.case": ("Case",),
    "case.compare.comparison": ("compare_case",),
    "springs.constants.homogenise": ("homogenise",),
    "springs.constants.stiffness": ("isotropic_moduli",),
    "springs.constants.zones": ("calibrate_zones",),
    "springs.dynamics.integrate": ("State", "motion", "recommended_time_step"),
    "springs.dynamics.integrators": ("INTEGRATORS",),
    "springs.dynamics.spectrum": ("natural_frequencies",),
    "bench.judging.evidence": ("judge",),
    "bench.judging.sweep": ("run",),
    "springs.lattice": (
        *("cut_lattice", "fill", "fill_rotated", "mesh_lattice", "patterns", "square"),
        *("triangular", "voronoi", "voronoi_box"),
    ),
    "springs.network": ("spring_network",),
    "api": ("body", "build", "equilibrium", "reference", "solve"),
    "bench.output.animation": ("animate",),
    "case.report.solutions": ("compare", "plot"),
    "problem": (
        *("Anisotropic", "Ball", "BodyForce", "Box", "Isotropic", "Mesh", "PointForce", "Polygon"),
        *("Problem", "ProblemError", "Region", "SolverError", "Support", "Traction"),
        *("Weight", "Zone"),
    ),
    "springs.dynamics.relax": ("algorithm1", "relax"),
    "springs.dynamics.relaxations": ("RELAXATIONS",),
    "springs.statics.stress": ("fitted_stress",),
}
"""Module -> the names of it that are offered here."""

_SYNONYMS = {"fem": "reference", "simulate": "relax", "problem": "Problem"}
"""Name that users try -> name that is offered."""

__all__ = ["__version__", *sorted(name for names in _HOMES.values() for name in names)]  # noqa: PLE0604

if TYPE_CHECKING:  # the same for readers of types
    from msvalidate.api import body as body
    from msvalidate.api import build as build
    from msvalidate.api import equilibrium as equilibrium
    from msvalidate.api import reference as reference
    from msvalidate.api import solve as solve
    from msvalidate.bench.judging.evidence import judge as judge
    from msvalidate.bench.judging.sweep import run as run
    from msvalidate.bench.output.animation import animate as animate
    from msvalidate.case.compare.comparison import compare_case as compare_case
    from msvalidate.case.file.building import read_case as read_case
    from msvalidate.case.file.case import Case as Case
    from msvalidate.case.report.solutions import compare as compare
    from msvalidate.case.report.solutions import plot as plot
    from msvalidate.problem import Anisotropic as Anisotropic
    from msvalidate.problem import Ball as Ball
    from msvalidate.problem import BodyForce as BodyForce
    from msvalidate.problem import Box as Box
    from msvalidate.problem import Isotropic as Isotropic
    from msvalidate.problem import Mesh as Mesh
    from msvalidate.problem import PointForce as PointForce
    from msvalidate.problem import Polygon as Polygon
    from msvalidate.problem import Problem as Problem
    from msvalidate.problem import ProblemError as ProblemError
    from msvalidate.problem import Region as Region
    from msvalidate.problem import SolverError as SolverError
    from msvalidate.problem import Support as Support
    from msvalidate.problem import Traction as Traction
    from msvalidate.problem import Weight as Weight
    from msvalidate.problem import Zone as Zone
    from msvalidate.springs.bodies.calibrate import calibrate as calibrate
    from msvalidate.springs.bodies.cut_network import cut_network as cut_network
    from msvalidate.springs.bodies.fit import fitted_constants as fitted_constants
    from msvalidate.springs.bodies.lattice_network import lattice_network as lattice_network
    from msvalidate.springs.bodies.mesh_file import read_mesh as read_mesh
    from msvalidate.springs.constants.homogenise import homogenise as homogenise
    from msvalidate.springs.constants.stiffness import isotropic_moduli as isotropic_moduli
    from msvalidate.springs.constants.zones import calibrate_zones as calibrate_zones
    from msvalidate.springs.dynamics.integrate import State as State
    from msvalidate.springs.dynamics.integrate import motion as motion
    from msvalidate.springs.dynamics.integrate import recommended_time_step as recommended_time_step
    from msvalidate.springs.dynamics.integrators import INTEGRATORS as INTEGRATORS
    from msvalidate.springs.dynamics.relax import algorithm1 as algorithm1
    from msvalidate.springs.dynamics.relax import relax as relax
    from msvalidate.springs.dynamics.relaxations import RELAXATIONS as RELAXATIONS
    from msvalidate.springs.dynamics.spectrum import natural_frequencies as natural_frequencies
    from msvalidate.springs.lattice import cut_lattice as cut_lattice
    from msvalidate.springs.lattice import fill as fill
    from msvalidate.springs.lattice import fill_rotated as fill_rotated
    from msvalidate.springs.lattice import mesh_lattice as mesh_lattice
    from msvalidate.springs.lattice import patterns as patterns
    from msvalidate.springs.lattice import square as square
    from msvalidate.springs.lattice import triangular as triangular
    from msvalidate.springs.lattice import voronoi as voronoi
    from msvalidate.springs.lattice import voronoi_box as voronoi_box
    from msvalidate.springs.network import spring_network as spring_network
    from msvalidate.springs.statics.stress import fitted_stress as fitted_stress


def __getattr__(name: str) -> object:
    """A name of `__all__`, imported now (PEP 562)."""
    for module, names in _HOMES.items():
        if name in names:
            globals()[name] = getattr(import_module(f"{__name__}.{module}"), name)
            return globals()[name]
    near = get_close_matches(_SYNONYMS.get(name, name), __all__, 1, 0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}{hint}")


def __dir__() -> list[str]:
    return list(__all__)
