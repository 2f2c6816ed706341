"""
Patch test
==========

Do springs on an irregular mesh reproduce a uniform stress exactly?

A method passes the patch test if it does so on any mesh, up to rounding
[ZienkiewiczTaylorZhu2013]. Zero-length springs with a volume energy pass it. Springs with stiffness
by area [vanGelder1998] do not.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms
import reference_fem

# %%
# A unit square is divided into triangles of size 1/6 m. The nodes are moved by random vectors.
# Nodes of a side stay on it.

square = reference_fem.box_discretisation(ms.Box(1, 1), (6, 6), "P1")
x = square.points
shift = 4 * x * (1 - x) * np.random.default_rng(1).uniform(-1, 1, x.shape)
sliding = {ms.Region((0, None)): (0, None), ms.Region((None, 0)): (None, 0)}
pull = {ms.Region((1, None)): (1e3, 0)}

# %%
# The exact displacement under the stress σ is linear: u = (σ/E) (x, -νy). The error is the largest
# difference relative to the elongation of the sheet. The springs by area fail on the regular mesh,
# too: their effective material is a different one.

distortions = np.linspace(0, 0.06, 7)
for route, label in ((None, "springs by area"), ("neo-Hookean", "zero-length springs")):
    errors = []
    for distortion in distortions:
        mesh = ms.Mesh(x + distortion * shift, square.cells, "triangle")
        problem = ms.body(mesh, ms.Isotropic(E=1e5, nu=1 / 3), fixed=sliding, traction=pull)
        springs = ms.solve(ms.build(problem, "mesh edges", route=route))
        exact = 0.01 * mesh.points * (1, -1 / 3)
        errors.append(abs(springs.displacement - exact).max() / 0.01)
    plt.semilogy(distortions, errors, "o-", label=label)
    print(f"{label}: largest error {max(errors):.1e}, passes below 1e-12")
sketch = springs.plot()
plt.xlabel("bound of the shifts (m)")
plt.ylabel("error relative to the elongation (1)")
plt.legend()
