"""
k2 = 2 k1
=========

Are springs with k2 = 2 k1 incompressible?

The source report states so of the square lattice with axial springs k1 and diagonal springs k2
[Report]. An incompressible sheet in plane stress has Poisson's ratio 1/2 in all directions.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

# %%
# A block is in uniaxial stress along any direction n if each side bears the traction of the stress
# tensor. Point supports remove the rigid-body motions and have no reaction. The lateral strain is
# the trace of the displacement gradient less the strain along n.

directions, ratios = np.radians(range(-45, 50, 5)), []
supports = {ms.Region((0, 0)): 0, ms.Region((1, 0)): (None, 0)}
for direction in directions:
    n = np.array([np.cos(direction), np.sin(direction)])
    pull = {"right": n[0] * n, "top": n[1] * n, "left": -n[0] * n, "bottom": -n[1] * n}
    problem = ms.body(ms.Box(1, 1), ms.Isotropic(E=1, nu=0), fixed=supports, traction=pull)
    springs = ms.solve(ms.build(problem, cells=5, constants=(1, 2)))
    gradient = np.linalg.lstsq(springs.network.points, springs.displacement)[0]
    ratios.append(1 - np.trace(gradient) / (n @ gradient @ n))
sketch = springs.plot()

# %%
# The effective tensor of the lattice has the ratio (2/5 - q)/(3/5 - q) at the angle φ to an axis,
# with q = (3/8) sin²(2φ): 2/3 along the axial springs and 1/9 along the diagonals [Nye1957].

q = 3 / 8 * np.sin(2 * directions) ** 2
theory = (0.4 - q) / (0.6 - q)
plt.plot(np.degrees(directions), theory, label="theory")
plt.plot(np.degrees(directions), ratios, "o", label="springs, 5 x 5 cells")
plt.axhline(0.5, color="k", ls="--", label="incompressible")
plt.xlabel("direction of the stress (degrees)")
plt.ylabel("Poisson's ratio (1)")
plt.legend()
print(f"springs: {ratios[9]:.4f} along the axes, {ratios[0]:.4f} along the diagonals")
print(f"largest difference from theory: {abs(ratios - theory).max():.1e}, at most 1e-10")
