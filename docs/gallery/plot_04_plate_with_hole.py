"""
Plate with a hole
=================

How large is the stress concentration at a circular hole in a plate under tension?

In an infinite plate the stress at the edge of the hole is 3 times the remote stress [Kirsch1898].
If the hole covers the part d of the width, it is (2 + (1 - d)³)/(1 - d) times [Heywood1952]. Here
d is 0.1, and the factor is 3.03.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms
import reference_fem

# %%
# One quarter of the plate is enough. The mesh of a unit square is mapped onto it, with one side
# along the hole of radius 1 m and smaller elements near the hole.

square = reference_fem.box_discretisation(ms.Box(1, 1), (10, 12), "Q2")
distance, angle = np.split(square.points * (3, np.pi / 2), 2, axis=1)
circle = np.hstack([np.cos(angle), np.sin(angle)])
outline = (20, 10) * circle / circle.max(axis=1, keepdims=True)
nodes = circle + np.expm1(distance) / np.expm1(3) * (outline - circle)
mesh = ms.Mesh(nodes, square.cells, "quad9")
symmetry = {ms.Region((0, None)): (0, None), ms.Region((None, 0)): (None, 0)}
pull = {ms.Region((20, None)): (1, 0)}
problem = ms.body(mesh, ms.Isotropic(E=1e5, nu=1 / 3), fixed=symmetry, traction=pull)
sketch = ms.plot(problem)

# %%
# The stress is compared along the narrowest section, x = 0. The square lattice is cut to
# the outline, so that its stress at the hole has an error of first order in the spacing.

y = np.linspace(1, 4)
elements = ms.reference(problem, rtol=1e-3).at([[0, 1]]).stress[0, 0]
springs = ms.solve(ms.build(problem, spacing=1 / 8))
section = springs.network.points[:, 0] == 0
plt.plot(y, 1 + 0.5 / y**2 + 1.5 / y**4, label="Kirsch")
plt.plot(1, elements, "ks", label="elements")
plt.plot(springs.network.points[section, 1], springs.stress[section, 0], "o", label="springs")
plt.xlim(0.95, 4)
plt.xlabel("y (m)")
plt.ylabel("stress σxx over the remote stress (1)")
plt.legend()
print(f"elements: {elements:.3f}, Kirsch: 3, Heywood: 3.032")
print(f"elements, relative difference from Kirsch: {elements / 3 - 1:.3f}, at most 0.02")
