"""
Stability map of integrators
============================

Which time steps are stable, for which scheme and damping ratio?

Every mode shape of a network is an oscillator with a natural frequency ω and a damping ratio ζ. A
scheme is stable if all eigenvalues of its one-step matrix lie in the unit circle [Jury1964].
"""

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms
from msvalidate.springs.dynamics.step_limits import stability_limit

# %%
# Each curve is the critical time step of a scheme. Explicit Euler is unstable without damping.
# Euler-Cromer is semi-implicit (symplectic) Euler with the viscous force at the old velocity.

zeta = np.linspace(0, 2, 201)
schemes = "explicit_euler", "euler_cromer", "leapfrog", "velocity_verlet", "runge_kutta"
for name, style in zip(schemes, ("C0", "C1", "k--", "k-.", "k:"), strict=True):
    limits = [stability_limit(name, 1, 1, 2 * each) for each in zeta]
    plt.plot(zeta, limits, style, label=ms.INTEGRATORS[name].title)
plt.axis((0, 2, 0, 3))
plt.xlabel("damping ratio ζ (1)")
plt.ylabel("critical time step times ω (1)")
plt.legend()

# %%
# The highest natural frequency of a network decides. A small load starts the motion of a cantilever
# with the damping ratio 1/2, for which the limit of Euler-Cromer is 2(√(1 + ζ²) - ζ)/ω. The load is
# small because springs at large amplitude limit the growth.

material = ms.Isotropic(E=1e5, nu=1 / 3, density=1000)
problem = ms.body(ms.Box(0.4, 0.1), material, fixed="left", gravity=(0, -0.01))
network = ms.build(problem, cells=2)
sketch = ms.plot(network)
highest = ms.natural_frequencies(network, 1).highest
start = ms.State(network.points, 0 * network.points)
limit = stability_limit("euler_cromer", 1, 1, 1)
for part in (0.99, 1.01):
    dt = part * limit / highest
    end = ms.motion(network, start, "euler_cromer", dt, 2000, highest, warn=False)
    print(f"largest velocity at {part} of the limit: {abs(end.velocity).max():.0e} m/s")
print(f"limit: {limit:.6f}, difference from theory: {abs(limit - 5**0.5 + 1):.1e}, at most 1e-10")
