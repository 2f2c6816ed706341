"""
Poisson's ratio of lattices by angle
====================================

Does Poisson's ratio of a lattice depend on the direction of the stress?

An isotropic lattice has one ratio. The square lattice with axial springs k1 and diagonal springs k2
is isotropic only if k2 = k1/2 [OstojaStarzewski2002].
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

# %%
# A uniaxial stress along (c, s) has the components (c², s², cs). The effective tensor of the unit
# cell gives its strain. The trace of the strain is the sum of the axial and the lateral strain.
#
# The theory is k1/(k1 + 4 k2) along the diagonals of the square lattice, 1/3 for the triangular
# lattice and (k1 + 3 k2)/(k1 + 9 k2) for the honeycomb. The sketch shows the honeycomb, with its
# springs to nearest and next neighbours.

angle = np.linspace(0, np.pi / 2, 91)
c, s = np.cos(angle), np.sin(angle)
stress = np.array([c * c, s * s, c * s])
for name, constants, style, theory in (
    ("square", (1, 0.5), "C0", 1 / 3),
    ("square", (1, 1), "C1", 1 / 5),
    ("triangular", (1,), "k--", 1 / 3),
    ("honeycomb", (3, 1), "k:", 1 / 2),
):
    pattern = getattr(ms.patterns, name)()
    strain = np.linalg.solve(ms.homogenise(pattern, constants).tensor, stress)
    ratio = 1 - (strain[0] + strain[1]) / (stress * strain).sum(axis=0)
    plt.plot(np.degrees(angle), ratio, style, label=f"{name}, k = {constants}")
    print(f"{name}, k = {constants}: {ratio[0]:.4f} along 0°, {ratio[45]:.4f} along 45°")
    print(f"difference from theory along 45°: {abs(ratio[45] - theory):.1e}, at most 1e-10")
plt.xlabel("direction of the stress (degrees)")
plt.ylabel("Poisson's ratio (1)")
plt.legend()
sketch = ms.plot(ms.fill(pattern, ms.Box(3**0.5 * 4, 9), (4, 3)))
