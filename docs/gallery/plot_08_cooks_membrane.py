"""
Cook's membrane
===============

How fast do springs and finite elements converge on a tapered panel under shear?

The deflection at the middle of the right side is 23.967 m for E = 1 Pa, a Poisson's ratio of 1/3
and the force 1 N [Cook1974].
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms
import reference_fem
from reference_fem.mesh.outlines import outline_discretisation

# %%
# The left side is clamped. A square lattice is cut to the outline, and linear triangles have the
# same spacing.

panel = ms.Polygon(((0, 0), (48, 44), (48, 60), (0, 44)))
clamp, pull = ms.Segment((0, 44), (0, 0)), {ms.Segment((48, 44), (48, 60)): (0, 1 / 16)}
problem = ms.body(panel, ms.Isotropic(E=1, nu=1 / 3), fixed=clamp, traction=pull)
sketch = ms.plot(problem)
spacings, probe, theory, deflections = [8, 4, 2, 1, 0.5], np.array([[48, 52.0]]), 23.967, []
for spacing in spacings:
    springs = ms.solve(ms.build(problem, spacing=spacing))
    mesh = outline_discretisation(panel, spacing, probe)
    elements = reference_fem.solve_problem(problem, mesh).at(probe)
    deflections.append((springs.answer.at(probe)[0, 1], elements[0, 1]))

# %%
# The errors decrease almost with the square of the spacing. The stress singularity at the clamped
# upper corner of 108 degrees lowers the order of convergence on very fine meshes [Williams1952].

errors = abs(np.array(deflections) / theory - 1)
plt.loglog(spacings, errors, "o-", label=["springs", "linear triangles"])
plt.xticks(spacings, spacings)
plt.minorticks_off()
plt.xlabel("spacing (m)")
plt.ylabel("relative error of the deflection (1)")
plt.legend()
print("springs, elements (m):", np.round(deflections[-1], 3), "theory:", theory)
print(f"relative difference of springs: {errors[-1, 0]:.4f}, at most 0.001")
