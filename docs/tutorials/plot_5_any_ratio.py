r"""
Any Poisson's ratio
===================

Springs alone represent one isotropic material. This tutorial computes their error for a body with
a different Poisson's ratio. It then adds a volume energy, which removes the error. Near the ratio
1/2, the comparison with simple finite elements shows locking.
"""

# %%
# One material
# ------------
#
# A central spring resists a change of its length, and nothing else. Its force acts along the line
# that joins its points. Suppose that all points of a lattice move with the mean strain. Then the
# stiffness tensor is a sum over springs of terms that are symmetric in all four indices. Such a
# tensor obeys the Cauchy relation: the two Lamé constants λ and μ are equal.
#
# Therefore Poisson's ratio is fixed:
#
# .. math:: \nu = \frac{\lambda}{2 (\lambda + \mu)} = \frac{1}{4}
#
# in 3D and in plane strain. In plane stress it is 1/3. No choice of the spring constants
# changes it as long as the lattice is isotropic and its points follow the mean strain.
#
# Volume energy
# -------------
#
# Add a term that resists a change of the area or volume V of each cell:
#
# .. math:: W = \frac{\kappa V_0}{2} \left(\frac{V}{V_0} - 1\right)^2.
#
# It increases λ by κ and does not change μ, since shear conserves the volume. With
# springs that supply μ and cells that supply λ - μ, every Poisson's ratio is available. Below the
# ratio of the springs, κ is negative and the network remains stable.
#
# ``build`` selects the route itself. It uses springs alone if they suffice, and otherwise
# springs with a volume energy.
#
# The experiment
# --------------
#
# A cantilever of 4 m x 1 m is clamped on its left side and loaded on its right side, in plane
# strain. Three models are compared with a converged finite element solution:
#
# 1. springs alone, with the same Young's modulus and the ratio 1/4,
# 2. springs with a volume energy,
# 3. bilinear quadrilateral elements ("Q1") on the mesh of the lattice.
#
# All three have eight cells over the height. `reference` refines quadratic elements until its error
# is below 1 %. The horizontal axis of the figure is 1/2 - ν, because the interesting range lies
# next to 1/2. Before you run it, sort the three models by their error at 0.3 and at 0.4999.

import matplotlib.pyplot as plt

import msvalidate as ms
import reference_fem

mesh = reference_fem.box_discretisation(ms.Box(4, 1), (32, 8), "Q1")
gaps = [0.5, 0.25, 0.05, 0.01, 1e-3, 1e-4]  # 1/2 - nu
tips = []
for gap in gaps:
    rubber = ms.Isotropic(1e5, 0.5 - gap, state="plane_strain")
    problem = ms.body(ms.Box(4, 1), rubber, fixed="left", traction={"right": (0, -10)})
    network = ms.build(problem, cells=8)
    solutions = [
        ms.reference(problem, 0.01).at(network.points).displacement,
        ms.solve(network).displacement,
        reference_fem.solve_problem(problem, mesh, allow_locked=True).at(network.points),
        ms.solve(ms.build(problem, cells=8, constants=(8e4, 4e4))).displacement,
    ]
    tips.append([-u[-1, 1] for u in solutions])  # m
plt.semilogx(gaps, tips, "o-", label=["reference", "volume energy", "Q1", "springs alone"])
plt.xlabel("1/2 - Poisson's ratio")
plt.ylabel("deflection of the tip (m)")
plt.legend()

# %%
# Reading the figure
# ------------------
#
# .. list-table:: Deflection of the tip, error in %
#    :header-rows: 1
#
#    * - Poisson's ratio
#      - springs alone
#      - volume energy
#      - Q1 elements
#    * - 0
#      - -7.7
#      - -3.1
#      - -0.9
#    * - 0.25
#      - -2.2
#      - -2.2
#      - -1.0
#    * - 0.45
#      - 16
#      - -2.0
#      - -4.9
#    * - 0.4999
#      - 23
#      - -2.3
#      - -90
#
# - **Springs alone** are a different effective material. Their deflection is the same for every
#   ratio. The error is a model error, which a finer lattice does not remove.
# - **The volume energy** keeps the error at 2 to 3 %. This is the discretisation error of eight
#   cells, and refinement reduces it.
# - **Q1 elements** lock. The material resists a change of volume at all four integration points of
#   an element. The element has too few degrees of freedom to bend without such a change.
#
# The volume energy of a square cell depends on one number, its mean change of area. This is
# the same as reduced integration of the volumetric part, a standard remedy for locking.
# A lattice of triangles with an energy in each triangle would lock again.
# The program rejects locked elements by default. The argument ``allow_locked`` shows them.
#
# Exercises
# ---------
#
# 1. Which sign has κ at the ratio 0? Why is the network stable? ``print(network)`` reports κ.
# 2. Repeat the experiment with 16 cells over the height. Which errors become smaller?
# 3. The material of a thin sheet is in plane stress. For which ratio do springs alone suffice?
# 4. How does κ grow near 1/2, and what happens to the critical time step?

# %%
# Answers
# -------
#
# 1. κ is negative: λ - μ = -E/2 = -50 kN/m for a thickness of 1 m. Springs and cells together
#    have the bulk modulus λ + μ in 2D. It is positive for every ratio between -1 and 1/2.
# 2. The volume energy improves by a factor of three to four, and its error is below 1 % at each
#    ratio. Q1 elements improve by the same factor at the ratio 0. At 0.4999 their error is still
#    80 %. The error of springs alone remains 6 % at the ratio 0, and grows to 25 % at 0.4999.
# 3. For the ratio 1/3.
# 4. κ grows as 1/(1/2 - ν), like λ. The highest natural frequency grows as its square root. The
#    time step that ``recommended_time_step`` returns for leapfrog is 5.5 ms at 0.45 and 0.26 ms at
#    0.4999.
