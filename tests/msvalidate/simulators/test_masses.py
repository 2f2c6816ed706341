"""Masses by motion: right ones, wrong ones by name, and forces from outside refused."""

import numpy as np
import pytest

from msvalidate.problem import Isotropic
from msvalidate.simulators.exchange.protocol import SimulatorError
from msvalidate.simulators.probe.bench import Bench
from msvalidate.simulators.probe.block import Block, probe_mesh
from msvalidate.simulators.probe.masses import _relative_error, measure_masses
from msvalidate.simulators.verdict.sentences import text_of
from tests.msvalidate.simulators.little import Little, Tetrahedra, isotropic, lame, linear, lumped
from tests.table import table

MATERIAL = Isotropic(1e7, 0.3, "solid")
MESH = probe_mesh()
OWN = lumped(MESH, MATERIAL.density)
# What masses must be known to. Explicit steps: rounding over the move; implicit ones in single
# precision are differences of rounded positions, and a hundredth is what is told apart.
LIMITS = {("float64", False): 1e-10, ("float64", True): 1e-9, ("float32", False): 1e-4,
          ("float32", True): 1e-2}  # fmt: skip


def measured(kind="float64", implicit=False, **faults):
    def make(mesh, k):
        return Tetrahedra(mesh, linear(isotropic(*lame(1e7, 0.3))), k)

    block = Block(MESH, MATERIAL)
    return measure_masses(Bench(Little(make, implicit, kind, **faults), block, 2.0**-13, kind))


@table("kind, implicit", LIMITS)
def test_right_masses_are_found_within_what_is_told(kind, implicit):
    found = measured(kind, implicit)
    off = np.abs(found.values / OWN - 1).max()
    assert off < LIMITS[kind, implicit]
    assert off < found.error  # what it says of itself
    assert found.pattern == "each node's own share"
    assert found.best == pytest.approx(OWN, rel=1e-12)


@table("kind", ["float64", "float32"])
def test_one_node_of_twice_its_mass_is_named(kind):
    masses = OWN * np.where(np.arange(len(OWN)) == 17, 2, 1)
    found = measured(kind, masses=masses)
    assert found.exceptions.tolist() == [17]
    assert found.pattern == "each node's own share"
    assert "node 17 2 times" in text_of(found.words)
    assert found.known is None


def test_shares_by_count_and_last_cell_are_told_apart():
    counted = np.bincount(MESH.cells.ravel()).astype(float)
    assert "a share for each cell" in measured(masses=counted).pattern
    few_digits = np.array([float(f"{mass:.4g}") for mass in OWN])
    assert measured(masses=few_digits).pattern == "each node's own share"
    wild = np.random.default_rng(1).uniform(1, 3, len(OWN))
    found = measured(masses=wild)
    assert found.pattern == ""
    assert found.values / wild == pytest.approx(OWN.sum() / wild.sum(), rel=1e-9)


def test_forces_from_outside_are_refused():
    with pytest.raises(SimulatorError, match="masses"):
        measured(outside=lambda x: -1e6 * x)


def test_a_body_that_does_not_move_is_refused():
    with pytest.raises(SimulatorError, match="no node moved"):
        measured(keep=0.0)


def test_masses_that_rows_leave_open_are_not_known():
    singular = np.array([1.0, 0.5, 0.2, 0.0, 0.0])
    assert _relative_error(singular, np.eye(5), 6) == np.inf
