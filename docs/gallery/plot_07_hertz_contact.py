"""
Hertz contact
=============

How wide is the contact patch of a rigid cylinder that is pressed into an elastic block?

On a half-plane, a cylinder of radius R under the force P touches the width 2a with
a² = 4PR/(πE), under the peak pressure 2P/(πa) [Johnson1985]. Force and modulus are those of plane
stress, per metre of thickness.
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms
from msvalidate.problem import Contact, Obstacle

# %%
# The force is chosen for a half-width of a tenth of the block's height. A parabola replaces the
# cylinder, as in the theory of Hertz.

E, R, a, block = 1e6, 1.0, 0.1, ms.Box(2, 1)  # Pa, m, m
P = np.pi * E * a**2 / (4 * R)  # N
contact = Contact(block.side("top"), Obstacle("parabola", (1, 1), (0, -1), R), force=P)
material = ms.Isotropic(E=E, nu=1 / 3)
problem = ms.Problem(block, material, ms.Support("bottom"), contacts=(contact,))

# %%
# Springs meet the obstacle without friction: contact forces are compressive, and zero at a gap.

springs = ms.solve(ms.build(problem, cells=64))
sketch = springs.plot()
patch = springs.contact.contacts[0]
theory = np.linspace(-a, a, 101)
peak = 2 * P / (np.pi * a)
plt.plot(theory, peak * np.sqrt(1 - (theory / a) ** 2), label="Hertz")
plt.plot(springs.network.points[patch.points, 0] - 1, patch.pressure, "o", label="springs")
plt.xlim(-2 * a, 2 * a)
plt.xlabel("distance from the axis (m)")
plt.ylabel("contact pressure (Pa)")
plt.legend()

# %%
# The half-width follows from the second moment of the contact forces, which resolves it better than
# a count of the points in contact.

print(f"peak pressure: springs {patch.pressure.max():.0f} Pa, Hertz {peak:.0f} Pa")
print(f"half-width: springs {patch.half_width:.5f} m, Hertz {a:.5f} m")
print(f"relative difference: {patch.half_width / a - 1:.4f}, at most 0.01")
