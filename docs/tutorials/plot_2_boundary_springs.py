"""
Boundary springs
================

A spring in the boundary of a body belongs to fewer cells than a spring inside. If it has the
stiffness of an interior spring, the body is too stiff. For five cells across, the axial springs are
20 % too stiff, and refinement removes the error slowly. This tutorial measures the error and
corrects it.
"""

# %%
# Half a side is missing
# ----------------------
#
# The springs of a lattice represent a solid because each cell stores the elastic energy of the
# solid that it covers. A side between two cells belongs half to the cell on its left and
# half to the cell on its right. Its stiffness k1 is the sum of the two halves.
#
# One of the two cells is missing at the boundary. The side has the boundary weight 1/2, so that
# its stiffness is k1/2. In 3D, a spring in a face of the body has the weight 1/2 and a spring on
# an edge of it 1/4. A diagonal of the square lattice lies inside its cell and has the weight 1.
#
# The mass follows the same rule. A lumped mass is the density times the volume that belongs to
# the point. This is a quarter of a cell at a corner, and half a cell at a side.
#
# Loads follow it as well. A uniform traction on the right side puts the same force on each point
# of that side, and half of it on the two corners. A program that applies equal forces to all
# points of the side applies too much load at the corners.
#
# The experiment
# --------------
#
# Pull a square block of N x N cells, with the left and the lower side on rollers. The exact
# solution for the solid is a uniform strain. The displacement is then a linear function of the
# coordinates, and a correct model reproduces it to rounding. In the finite element method this is
# called the patch test.
#
# ``lattice_network`` takes the rule for the weights: "shared" has the weights described above,
# and "equal" has the weight 1 everywhere. The block is 1 m long in all cases, so that refinement
# changes the cells and not the body.
#
# Two numbers describe the result: the mean and the largest error of the horizontal displacement
# of the pulled side. Both are relative to the exact displacement, 1 mm.

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

box = ms.Box(1, 1)  # m
# The Young's modulus of 4/3 Pa belongs to k1 = 1 N/m and k2 = 1/2 N/m.
problem = ms.body(
    box,
    ms.Isotropic(4 / 3, 1 / 3),
    fixed={"left": (0, None), "bottom": (None, 0)},
    traction={"right": (4e-3 / 3, 0)},
)

# %%
# Coarse to fine
# --------------
#
# Before you run the loop, estimate the error of a block with whole springs. A section across
# N cells cuts N + 1 horizontal springs in place of N. Which power of N do you expect, and is it
# the same for both errors?

cells = 5 * 2 ** np.arange(5)
errors = []
for n in cells:
    network = ms.lattice_network(problem, ms.square(box, n), weights="equal")
    u = ms.solve(network).displacement[network.points[:, 0] == 1, 0]  # m
    errors.append((1 - u.mean() / 1e-3, 1 - u.min() / 1e-3))
plt.loglog(cells, 1 / cells, "k:", label="stiffness of the axial springs, 1/N")
plt.loglog(cells, errors, "o-", label=["mean", "largest"])
plt.xlabel("number of cells across, N")
plt.ylabel("relative error of the displacement")
plt.legend()

# %%
# The estimate and the result
# ---------------------------
#
# The axial springs of a section are too stiff by 1/N, which is 20 % for five cells. The diagonals
# have the correct stiffness. Young's modulus of the block is therefore 17 % too large, and the mean
# displacement is 14 % too small. The mean error is of first order in the spacing.
#
# The largest error is 28 % for five cells, and it decreases more slowly than 1/N. It occurs at
# the corner, where a point has half of the load but a whole spring in the boundary. A layer along
# the boundary lags behind the interior.
#
# First-order convergence is expensive. With half the spacing, a 2D lattice has four times as many
# points, and the critical time step is halved. One halving of this error costs eight times the
# computing time.
#
# Now repeat the loop with ``weights="shared"``. Both errors are zero to rounding for every number
# of cells, even for a single one. The correction is free.
#
# The same rule in other programs
# -------------------------------
#
# Many simulators take one stiffness for all edges of a mesh. If yours takes one number for each
# spring, multiply the stiffness by the boundary weight before you write the file. Otherwise,
# report the error together with the result. A fit of the modulus is valid at one spacing only.
#
# Exercises
# ---------
#
# 1. How many cells across does the block need, until whole springs cost less than 5 % of the mean
#    displacement? How many, until the largest error is below 5 %?
# 2. What is Poisson's ratio of a single cell with whole springs?
# 3. A cantilever bends. Its stiffness depends on the springs farthest from the centre line. Is
#    the error of its deflection larger or smaller than that of the pulled block?
# 4. Whole springs in the boundary raise the highest natural frequency. What happens to the
#    critical time step?

# %%
# Answers
# -------
#
# 1. The mean needs 16 cells, where the error is 4.98 %. The largest error needs 77 cells.
# 2. It is k2/(2 k1 + k2) = 0.2 in place of 1/3. Tutorial 1 derives the formula.
# 3. Larger. For five cells, the axial springs lie at the distances 0.5, 1.5 and 2.5 cells from the
#    centre line. Weigh the squares of the six distances: the sum is 17.5 with whole springs and
#    11.25 with the weight 1/2 in the outer rows. The axial springs are 56 % too stiff in bending.
#    The diagonals reduce this number: a cantilever of ten times its height bends 30 % too little.
# 4. The critical time step 2/ω becomes shorter, because ω is higher.
