"""What is exported for LAMMPS comes to rest there where our own nonlinear equilibrium is."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.simulators.exchange.lammps import lammps_files
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.msvalidate.case.springs.test_network_files import BRACKET, HOLES, case_of
from tests.peers.with_lammps import opened

CASES = {  # strains of some 1e-3: of smaller ones positions in double precision have fewer digits
    "plane, cut, moved": (case_of(HOLES, 1 / 3, 1e8, 2e-5, spacing=0.002), 0),
    "space, cut, moved": (case_of(BRACKET, 1 / 4, 5e7, 1e-3, spacing=0.05), 0),
    "after motion": (case_of(BRACKET, 1 / 4, 5e7, spacing=0.1), None),
}


@pytest.mark.parametrize(("case", "steps"), CASES.values(), ids=CASES)
def test_lammps_comes_to_the_same_rest(tmp_path, monkeypatch, case, steps):
    pytest.importorskip("lammps")
    found = solve_springs(case, case.spacing)
    for name, content in lammps_files(found.network, found.rest, "here").items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    lmp = opened()
    if steps is not None:
        lmp.command(f"variable steps index {steps}")
    lmp.file("springs.in")
    lmp.close()
    moved = np.loadtxt(tmp_path / "rest.dump", skiprows=9)[:, 1 : 1 + found.network.dim]
    wanted = equilibrium(found.network, "nonlinear").displacement
    size = np.abs(wanted).max()
    assert np.abs(found.rest.displacement - wanted).max() > 1e-4 * size  # bonds turn
    assert np.abs(moved - wanted).max() <= 1e-9 * size
