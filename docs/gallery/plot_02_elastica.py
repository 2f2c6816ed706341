"""
Elastica
========

How far does a slender cantilever bend under a large transverse force at its end?

The elastica, an inextensible bar without shear deformation, has a closed form in elliptic integrals
[BisshoppDrucker1945]. Its only parameter is PL²/(EI).
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import msvalidate as ms

# %%
# The slope θ of the tip gives the parameter m = (1 + sin θ)/2 of the integrals and their lower
# limit φ, with sin²φ = 1/(2m). Load and deflection then follow without iteration.

theta = np.linspace(0.01, 1.4, 200)
m = (1 + np.sin(theta)) / 2
phi = np.arcsin(np.sqrt(0.5 / m))
root = ellipk(m) - ellipkinc(phi, m)  # √(PL²/(EI))
deflection = 1 - 2 * (ellipe(m) - ellipeinc(phi, m)) / root

# %%
# The body is a strip of 20 x 1 m in plane stress. With E = 12 (L/h)² Pa, the traction in Pa is the
# parameter of the load. It keeps its direction (a dead load), and the displacement is finite.

rubber, loads, tips = ms.Isotropic(E=4800, nu=1 / 3), [1, 2, 4], []
for load in loads:
    body = ms.body(ms.Box(20, 1), rubber, fixed="left", traction={"right": (0, -load)})
    springs = ms.solve(ms.build(body, "square", cells=8), geometry="nonlinear")
    tips.append(-springs.displacement[springs.network.points[:, 0] == 20, 1].mean() / 20)
sketch = springs.plot()

# %%
# The sketch shows the largest load. The springs are stiffer than the elastica: their discretisation
# error in bending is of second order in the spacing, and four times as large with 4 cells.

plt.plot(root**2, deflection, label="elastica")
plt.plot(loads, tips, "o", label="springs, 8 cells")
plt.xlabel("load PL²/(EI) (1)")
plt.ylabel("deflection of the tip over L (1)")
plt.legend()
theory = np.interp(loads, root**2, deflection)
print("deflection over L, springs:", np.round(tips, 4), "theory:", theory.round(4))
print(f"largest relative difference: {abs(tips / theory - 1).max():.4f}, at most 0.02")
