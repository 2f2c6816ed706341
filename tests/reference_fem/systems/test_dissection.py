"""Nested dissection: every unknown once, halves before what parts them, and few entries."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from msvalidate.problem import Isotropic
from reference_fem.elasticity import stiffness
from reference_fem.systems.order import elimination_order


def entries(body, ordering):
    """Entries of a factor of a clamped body, with and without nested dissection."""
    held = np.repeat(body.points[:, :1] == 0, body.dim, axis=1)
    free = np.flatnonzero(~held.T.ravel())
    if ordering == "NATURAL":
        free = free[elimination_order(body, held)]
    law = Isotropic(1.0, 0.3, "solid" if body.dim == 3 else "plane_stress")
    A = csc_matrix(stiffness(body, law)[free][:, free])
    options = {"SymmetricMode": True}
    return splu(A, permc_spec=ordering, diag_pivot_thresh=0.0, options=options).nnz
