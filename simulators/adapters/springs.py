# SPDX-License-Identifier: MIT
"""Our own springs: a network of springs.csv, at rest or at given positions. Wants msvalidate.

Law: a central force k (|d| - L0) along each spring, msvalidate/springs/network/network.py. What
solid they stand for is the business of whoever made springs.csv; E and nu are not read.

Settings: ``geometry`` linear (default: one solve with the tangent at the points) or nonlinear
(Newton's method, springs along their present direction).
"""

import numpy as np
from exchange import Refusal, cannot, refuse_unknown, run, setting

import msvalidate
from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.network import internal_force, spring_network
from msvalidate.springs.statics.equilibrium import equilibrium


def answer(request):
    """Displacement of a network at rest, or the forces of one at `start`."""
    if request.springs is None:
        cannot("no springs.csv: springs are all that this one has; ask with springs")
    if request.task == "motion" and request.steps != 1:
        cannot(f"a motion of {request.steps} steps: this adapter answers one step by forces")
    geometry = setting(request, "geometry", ("linear", "nonlinear"))
    refuse_unknown(request)
    springs = request.springs
    about = {
        "simulator": "msvalidate",
        "version": msvalidate.__version__,
        "law": "central springs",
        "settings": {"geometry": [geometry, ""]},
        "steps": 1,
        "dt": None,
        "precision": "float64",
        "mass": "lumped",
        "forces_at": "start",
        "at_rest": {},
        "notes": "",
    }
    try:
        network = spring_network(
            request.points,
            springs.ends,
            springs.stiffness,
            rest_length=springs.length,
            mass=request.mass,
            fixed=request.held,
            displacement=np.where(request.held, request.value, 0.0),
            force=request.load,
        )
        if request.task == "motion":
            return about, {"force": internal_force(network, request.start)}
        found = equilibrium(network, geometry)
    except ProblemError as error:
        raise Refusal(str(error)) from None
    except SolverError as error:
        raise SystemExit(f"msvalidate: {error}") from None
    about["at_rest"] = {"residual": found.residual}
    return about, {"displacement": found.displacement}


if __name__ == "__main__":
    run(answer)
