"""
Hanging bar
===========

How far does a bar stretch under its own weight?

A bar of length L, density ρ and Young's modulus E that hangs from its top elongates by ρgL²/(2E)
[TimoshenkoGoodier1970]. Its displacement is a parabola of the height.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

# %%
# The left side is a plane of symmetry: only its displacement along x is zero. The top slides in its
# plane, so that no boundary condition hinders the lateral contraction.

L, E, rho, g = 1.0, 1e5, 1000.0, 9.81  # m, Pa, kg/m³, m/s²
material = ms.Isotropic(E=E, nu=1 / 3, density=rho)
supports = {"top": (None, 0), "left": (0, None)}
problem = ms.body(ms.Box(0.2, L), material, fixed=supports, gravity=(0, -g))

# %%
# Springs on the square lattice have the elastic constants of the material, and their lumped masses
# have its weight.

network = ms.build(problem, "square", cells=4)
sketch = ms.plot(network)
y, u = network.points[:, 1], ms.solve(network).displacement[:, 1]
height = np.linspace(0, L)
plt.plot(height, rho * g / (2 * E) * (height**2 - L**2), label="ρg(y² - L²)/(2E)")
plt.plot(y, u, "o", mfc="none", label="springs")
plt.xlabel("height y (m)")
plt.ylabel("vertical displacement (m)")
plt.legend()

# %%
# By reciprocity, the mean displacement of the lower end is the elongation of the theory, for any
# number of cells: a uniform stress is an exact solution of the network, too. The points of the
# lower end are weighted by their masses, which are half as large at the corners.

elongation = -np.average(u[y == 0], weights=network.mass[y == 0])
exact = rho * g * L**2 / (2 * E)
print(f"springs: {elongation:.6f} m, theory: {exact:.6f} m")
print(f"relative difference: {abs(elongation / exact - 1):.1e}, at most 1e-10")
