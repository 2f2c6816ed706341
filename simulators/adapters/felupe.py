# SPDX-License-Identifier: MIT
"""FElupe: linear tetrahedra and hexahedra, at rest or at given positions (11.3 tried).

Settings: ``law`` linear (default), `LinearElastic(E, nu)`: small strains, felupe's
constitution/linear_elasticity/_linear_elastic.py; or neo_hooke, `NeoHooke(mu, bulk)`: energy
mu/2 (J^(-2/3) tr C - 3) + bulk/2 (J - 1)² with mu = E / 2(1 + nu) and bulk = E / 3(1 - 2 nu), so
that it is Hooke's law to first order: constitution/hyperelasticity/_neo_hooke_nearly_
incompressible.py. ``tolerance`` of its Newton's method, a norm of what is out of balance
relative to that of the reactions (1e-8).

A motion of one step is answered by the assembled residual at `start`, the other way round.

Traps: forces and weight are point loads on the nodes. `newtonrhapson` has another spelling since
10.2. Loads come at once: neo_hooke may not find its rest where they are large. At strains of 1e-6
neo_hooke never came to a tolerance of 1e-10, and does to 1e-8.
"""

import sys
from importlib import metadata

import numpy as np
from exchange import cannot, refuse_unknown, run, setting

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
import felupe

REGIONS = {"tetra": felupe.RegionTetra, "hexahedron": felupe.RegionHexahedron}


def answer(request):
    """Displacement of a body at rest, or its forces at `start`."""
    if request.kind not in REGIONS:
        cannot(f"cells {request.kind}: this adapter gives FElupe tetra or hexahedron only")
    if request.task == "motion" and request.steps != 1:
        cannot(f"a motion of {request.steps} steps: FElupe's solver is static")
    law = setting(request, "law", ("linear", "neo_hooke"))
    tolerance = setting(request, "tolerance", 1e-8)
    refuse_unknown(request)
    mesh = felupe.Mesh(request.points, request.cells, request.kind)
    field = felupe.FieldContainer([felupe.Field(REGIONS[request.kind](mesh), dim=3)])
    body = felupe.SolidBody(material(request.material, law), field)
    about = {
        "simulator": "FElupe",
        "version": metadata.version("felupe"),
        "law": law,
        "settings": {"law": [law, ""], "tolerance": [tolerance, ""]},
        "steps": 1,
        "dt": None,
        "precision": "float64",
        "mass": "lumped",
        "forces_at": "start",
        "at_rest": {},
        "notes": "",
    }
    if request.task == "motion":
        field[0].values[:] = request.start - request.points
        return about, {"force": -inner(body, field)}
    loaded = np.flatnonzero(request.load.any(axis=1))
    load = felupe.PointLoad(field, loaded, request.load[loaded])
    held, free = np.flatnonzero(request.held), np.flatnonzero(~request.held)
    felupe.newtonraphson(
        items=[body, load],
        dof0=held,
        dof1=free,
        ext0=request.value[request.held],
        tol=tolerance,
        verbose=0,
    )
    left = abs(inner(body, field) - request.load)[~request.held].max(initial=0.0)
    return {**about, "at_rest": {"residual": float(left)}}, {"displacement": field[0].values}


def material(asked, law):
    """Of felupe, with the moduli asked."""
    if law == "linear":
        return felupe.LinearElastic(E=asked.E, nu=asked.nu)
    mu, bulk = asked.E / 2 / (1 + asked.nu), asked.E / 3 / (1 - 2 * asked.nu)
    return felupe.NeoHooke(mu=mu, bulk=bulk)


def inner(body, field):
    """What holds the nodes where they are, (n, 3) N."""
    return body.assemble.vector(field).toarray().reshape(-1, 3)


if __name__ == "__main__":
    run(answer)
