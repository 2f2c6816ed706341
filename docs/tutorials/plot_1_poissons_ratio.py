"""
Poisson's ratio of a square lattice
===================================

A square lattice has springs of stiffness k1 along its axes and k2 along both diagonals of every
cell. This tutorial derives its Poisson's ratio twice: for one cell alone, and for a lattice. The
two results differ, and the difference has misled more than one author.

You need no knowledge beyond Hooke's law. Write down what you expect before you run a block.
"""

# %%
# The experiment
# --------------
#
# Take a square block. Its left side slides vertically and its lower side slides horizontally,
# so that the block may contract freely. The right side moves outwards by 0.1 % of the length.
# In the terms of finite elements, each of the three sides has a Dirichlet boundary condition for
# one component. The block has an edge of 1 m, so that Poisson's ratio is the downward displacement
# of the upper right corner divided by 1 mm.
#
# ``build`` gives each spring in the boundary half of its stiffness. Tutorial 2 explains the
# reason. All four sides of a single cell lie in the boundary. A cell with four whole springs of
# stiffness k1 is therefore built with 2 k1.

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

sides = {"left": (0, None), "bottom": (None, 0), "right": (1e-3, None)}  # m
problem = ms.body(ms.Box(1, 1), ms.Isotropic(1, 1 / 3), fixed=sides)

# %%
# One cell
# --------
#
# A single cell has four sides and two diagonals. Pull it along x with the total force F, and let
# it extend by a and contract by b. The cell has an edge of 1 m, so that a and b are strains too.
#
# Each diagonal has the direction (1, 1)/√2 and becomes longer by (a - b)/√2. Its force is k2 (a -
# b)/√2, and the component along either axis is k2 (a - b)/2. There are two diagonals, so that a
# section across the cell carries k2 (a - b) through them.
#
# The section also cuts two sides, the upper and the lower one. No external force acts along y.
# The balance of forces along y is therefore
#
# .. math:: -2 k_1 b + k_2 (a - b) = 0, \qquad \nu = \frac{b}{a} = \frac{k_2}{2 k_1 + k_2}.
#
# For k2 = k1/2 this is 0.2. The result is correct for this body. If 1/2 is wanted, the formula
# requires k2 = 2 k1, and this choice has been recommended for incompressible materials.

# %%
# A lattice
# ---------
#
# Now put many cells side by side. Two cells share each side between them. One cell in the interior
# owns half of its upper side and half of its lower side. This makes one k1 per cell in place of
# two.
#
# Replace 2 k1 by k1 in the balance of forces:
#
# .. math:: -k_1 b + k_2 (a - b) = 0, \qquad \nu = \frac{k_2}{k_1 + k_2}.
#
# For k2 = k1/2 this is 1/3. It is the only ratio at which the lattice is isotropic. For k2 = 2 k1
# it is 2/3, which exceeds 1/2. No isotropic 3D solid has such a ratio.
#
# Homogenisation gives the same result. The unit cell is the representative volume element of a
# periodic lattice, and ``ms.homogenise(ms.patterns.square(), (1, 0.5)).nu`` is 1/3.

# %%
# Along the diagonals
# -------------------
#
# An isotropic material has the same Poisson's ratio in every direction. A square lattice has
# three independent moduli. Turn the axes by 45 degrees: with Voigt's notation the ratio is
#
# .. math:: \nu_{45} = \frac{C_{11} + C_{12} - 2 C_{66}}{C_{11} + C_{12} + 2 C_{66}}
#           = \frac{k_1}{k_1 + 4 k_2}.
#
# Predict where the two curves of the lattice intersect before you look at the figure.

k2 = np.linspace(0.25, 2.5, 10)  # N/m; k1 is 1 N/m
for cells, k1, name in (1, 2, "one cell"), (6, 1, "lattice of 6 x 6 cells"):
    networks = (ms.build(problem, cells=cells, constants=(k1, k)) for k in k2)
    plt.plot(k2, [-1e3 * ms.solve(n).displacement[-1, 1] for n in networks], "ko")
    plt.plot(k2, k2 / (k1 + k2), label=name)
plt.plot(k2, 1 / (1 + 4 * k2), "--", label="lattice, along its diagonals")
plt.xlabel("stiffness ratio k2/k1")
plt.ylabel("Poisson's ratio")
plt.legend()

# %%
# The lines are the formulas, and the symbols are computed. The symbols lie on the lines. The two
# curves of the lattice intersect at k2 = k1/2, where the Zener ratio is 1 and Poisson's ratio is
# 1/3. Central springs alone offer no other isotropic material in 2D. Tutorial 5 adds an energy for
# other ratios.
#
# Exercises
# ---------
#
# 1. At which k2 does the lattice have the ratio 1/2 along its axes? Which ratio does it
#    have along its diagonals then?
# 2. Finite elements with the same E and the same ratio agree with the pulled lattice at every k2.
#    The lattice is isotropic at k2 = k1/2 only. Which load reveals the difference?
# 3. Compute the ratio of blocks of 2 x 2 and 10 x 10 cells. Does it depend on the number of cells?
# 4. The source of these formulas calls the lattice incompressible at k2 = 2 k1. Does the area of
#    the block increase or decrease under tension?

# %%
# Answers
# -------
#
# 1. The ratio is 1/2 at k2 = k1. Along the diagonals it is 1/5. A ratio of 1/2 along one direction
#    does not make a material incompressible.
# 2. Shear along the axes, or tension along the diagonals. The lattice has the shear modulus k2. The
#    elements have the Lamé constants λ = k2 and μ = k1/2. At k2 = 2 k1 the lattice is four times as
#    stiff in shear, and this factor is its Zener ratio. Its ratio along the diagonals is 1/9, and
#    that of the elements stays 2/3.
# 3. No. With boundary weights of 1/2, uniform tension is exact at any number of cells. The block
#    passes the patch test.
# 4. The change of area relative to the extension is 1 - ν. For a ratio of 2/3 the area increases by
#    a third of the extension. In a sheet in plane stress the volume depends on the thickness too,
#    so that this alone decides nothing. In 2D, only a ratio of 1 keeps the area.
