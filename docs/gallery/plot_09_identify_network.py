"""
Identify a network
==================

Which elastic solid is an irregular network of springs?

Springs join the neighbours of a Voronoi tessellation. Their stiffness is kA/L, with the length A of
the common side of two cells and the distance L of their centres. For files of points and springs,
``msvalidate advise --identify`` computes the same.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

# %%
# Young's modulus, Poisson's ratio and the Zener ratio follow from the effective tensor of a
# periodic unit cell. A hydrostatic strain moves all points affinely, so that the 2D bulk modulus
# E/(2(1 - ν)) is k/2 exactly, here for k = 1 N/m.
#
# If all points moved affinely, Cauchy's relation would give the ratio 1/3 [BornHuang1954]. The
# points of an irregular network relax, which lowers the shear modulus. Larger cells scatter less:
# they are closer to a representative volume element.

error = 0.0
for count, style in ((25, "C1s"), (400, "C0o")):
    for seed in range(10):
        pattern = ms.voronoi(count, points="blue_noise", seed=seed)
        moduli = ms.isotropic_moduli(ms.homogenise(pattern, (1,)).tensor)
        plt.plot(moduli.nu, moduli.E, style, label=None if seed else f"cells of {count} points")
        error = max(error, abs(moduli.E / (2 * (1 - moduli.nu)) - 0.5))
print(f"E = {moduli.E:.3f} N/m, nu = {moduli.nu:.3f}, Zener ratio = {moduli.zener:.3f}")
nu = np.linspace(0.3, 0.6)
plt.plot(nu, 1 - nu, "k:", label="bulk modulus k/2")
plt.plot(1 / 3, 2 / 3, "k^", label="affine motion")
plt.xlabel("Poisson's ratio (1)")
plt.ylabel("Young's modulus (N/m)")
plt.legend()
print(f"bulk modulus, largest difference from k/2: {error:.1e} N/m, at most 1e-10")
lattice = ms.voronoi_box(ms.Box(2, 1), 0.1, points="blue_noise", seed=seed)
sketch = ms.plot(lattice)
