"""Ten faults of the library itself, one at a time: a row of theory or agreement notices each.

The negative controls of a study are faults of its candidate. These are faults of what both sides,
or the study itself, are made of, which no candidate has.
"""

import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import reference_fem.body
import reference_fem.elasticity
from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.dielectric.actuator import Actuator
from msvalidate.problem import Isotropic
from msvalidate.springs.bodies import lattice_network, mesh_file
from msvalidate.springs.constants import stiffness
from msvalidate.springs.lattice import filled
from msvalidate.springs.network import configuration

OURS = ("msvalidate", "reference_fem", "studies")


def everywhere(patch, old, new):
    """Put one function in the place of another in every module that has imported it."""
    for name, module in list(sys.modules.items()):
        if name.startswith(OURS):
            for attribute in [key for key, value in vars(module).items() if value is old]:
                patch.setattr(module, attribute, new)


def shear_halved(patch):
    true = reference_fem.body.Solution.stress

    def stress(self, points):
        d = self.body.dim
        return true(self, points) * ([1.0] * d + [0.5] * (3 * (d - 1) - d))

    patch.setattr(reference_fem.body.Solution, "stress", stress)


def tangent_with_a_wrong_sign(patch):
    true = configuration.Configuration.tangent

    def blocks(at):
        # A network at rest as it lies has the elastic part alone.
        rest = replace(at.network, rest_length=at.length)
        return 2 * true(configuration.Configuration(rest, at.displacement)) - true(at)

    patch.setattr(configuration.Configuration, "tangent", blocks)


def swapped(voigt):
    pairs = list(voigt[3])
    pairs[3], pairs[4] = pairs[4], pairs[3]
    return tuple(pairs)


def springs_swap_yz_and_xz(patch):
    patch.setitem(stiffness.VOIGT, 3, swapped(stiffness.VOIGT))


def elements_swap_yz_and_xz(patch):
    patch.setitem(reference_fem.elasticity.VOIGT, 3, swapped(reference_fem.elasticity.VOIGT))


def ratio_without_its_sign(patch):
    true = Isotropic.__post_init__

    def checked(self):
        true(self)
        object.__setattr__(self, "nu", abs(self.nu))

    patch.setattr(Isotropic, "__post_init__", checked)


def elements_take_the_ratio_without_its_sign(patch):
    true = reference_fem.elasticity.elastic_tensor
    everywhere(patch, true, lambda law: true(replace(law, nu=abs(law.nu))))


def springs_take_the_ratio_without_its_sign(patch):
    true = stiffness.in_plane_moduli
    everywhere(patch, true, lambda law: true(replace(law, nu=abs(law.nu))))


def millimetres_read_as_metres(patch):
    true = mesh_file._coordinates
    patch.setattr(
        mesh_file, "_coordinates", lambda points, dim, _, *hint: true(points, dim, 1.0, *hint)
    )


def permittivity_dropped(patch):
    true = Actuator.__post_init__

    def checked(self):
        object.__setattr__(self, "permittivity", 1.0)
        true(self)

    patch.setattr(Actuator, "__post_init__", checked)


def equal_masses(patch):
    true = lattice_network.lattice_network
    everywhere(patch, true, lambda *asked, **named: true(*asked, **named | {"mass": "equal"}))


def longer_diagonals(patch):
    true = lattice_network.lattice_network

    def longer(*arguments, **named):
        net = true(*arguments, **named)
        along = np.abs(np.diff(net.points[net.springs], axis=1)[:, 0])
        diagonal = (along > 1e-9 * along.max()).sum(axis=1) > 1
        return replace(net, rest_length=net.rest_length * np.where(diagonal, 1.001, 1.0))

    everywhere(patch, true, longer)


def modulus_of_plane_stress_in_plane_strain(patch):
    true = stiffness.in_plane_moduli

    def plane(law):
        E, nu = true(law)
        return (law.E * law.thickness if law.state == "plane_strain" else E), nu

    everywhere(patch, true, plane)


def edges_in_space_halved(patch):
    true = filled.side_share
    everywhere(patch, true, lambda *arguments: np.maximum(true(*arguments), 0.5))


SOLID = "patch tests: elements and regular lattices, relative"
RING = "pressed ring, plane stress: shear and von Mises stress by Q2 over what it states to be off"
SHEARED = "orthotropic cubes: shear of springs and of elements over that on paper, from 1"
FAULTS = {
    "1 shear halved, patch": (shear_halved, "benchmarks", "patch", SOLID),
    "1 shear halved, hole": (
        shear_halved,
        "benchmarks",
        "hole",
        "Kirsch: shear and von Mises stress on the hole by Q2 over what it states to be off",
    ),
    "1 shear halved, ring": (
        shear_halved,
        "benchmarks",
        "ring",
        RING,
    ),
    "2 geometric tangent's sign": (
        tangent_with_a_wrong_sign,
        "convergence",
        "strained",
        "order of Newton's method at 5 to 10 % strain, last three distances",
    ),
    "3 yz and xz swapped, springs": (
        springs_swap_yz_and_xz,
        "lattices",
        "orthotropic",
        "orthotropic cubes: tensor against that on paper, relative",
    ),
    "3 yz and xz swapped, elements": (
        elements_swap_yz_and_xz,
        "lattices",
        "orthotropic",
        SHEARED,
    ),
    "4 abs around the ratio": (ratio_without_its_sign, "benchmarks", "patch", SOLID),
    "4 abs, elements": (elements_take_the_ratio_without_its_sign, "benchmarks", "patch", SOLID),
    "4 abs, springs": (springs_take_the_ratio_without_its_sign, "benchmarks", "patch", SOLID),
    "5 mm read as m": (
        millimetres_read_as_metres,
        "benchmarks",
        "from_file",
        "body from a file in mm: area and elongation of elements and springs, relative",
    ),
    "6 permittivity dropped, actuator": (
        permittivity_dropped,
        "actuator",
        "permittivity",
        "displacement at 2.7 F/m over that at 1 F/m and √2.7 times the voltage, from 1",
    ),
    "6 permittivity dropped, pull_in": (
        permittivity_dropped,
        "pull_in",
        "permittivity",
        "thickness at another permittivity against that at 1 F/m, voltages by their root",
    ),
    "7 equal masses": (
        equal_masses,
        "damping",
        "wave",
        "speed extrapolated to no spacing against c0, sides held",
    ),
    "8 diagonals 0.1 % longer": (
        longer_diagonals,
        "displacement",
        "identities",
        "uniform tension of square cells: displacement, relative",
    ),
    "9 plane strain's modulus": (
        modulus_of_plane_stress_in_plane_strain,
        "benchmarks",
        "ring",
        "pressed ring: order of the displacement of springs everywhere, all lattices",
    ),
    "10 edges in space halved": (edges_in_space_halved, "benchmarks", "patch", SOLID),
}
"""Name -> the fault, and study, question and row that notice it."""
SLOW = {"wave", "ring", "hole"}
CASES = [
    pytest.param(name, marks=[pytest.mark.slow] if FAULTS[name][2] in SLOW else [])
    for name in FAULTS
]


def asked(study, question):
    found = judge(catalogue.load(study).run(setting=Setting(quick=True), questions=(question,)))
    return found.set_index("quantity")


@cache
def sound(study, question):
    return asked(study, question)


def test_ten_are_asked():
    assert {name.split()[0] for name in FAULTS} == {str(n) for n in range(1, 11)}


@pytest.mark.parametrize("name", CASES)
def test_a_row_notices_the_fault(name, monkeypatch):
    fault, study, question, row = FAULTS[name]
    before = sound(study, question).loc[row]
    assert before["layer"] in {"theory", "agreement"}
    assert before["verdict"] == "pass"
    fault(monkeypatch)
    assert asked(study, question).loc[row, "verdict"] == "fail"
