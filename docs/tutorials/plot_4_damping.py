"""
Damping and the number of steps to equilibrium
==============================================

A static problem can be solved by motion: apply the load, damp the vibration, and wait. This is
dynamic relaxation. The damping decides how long it takes. Too little leaves a vibration, and
too much lets the body creep. This tutorial measures the number of steps for both.
"""

# %%
# One mode
# --------
#
# Let the viscous force on a point of mass m be -c m v, where c is a rate in 1/s. This is
# mass-proportional Rayleigh damping. It does not couple the modes. Each mode is an oscillator with
# its own natural frequency ω. Its damping ratio is
#
# .. math:: \zeta = \frac{c}{2 \omega}.
#
# - If ζ < 1, the mode vibrates, and its amplitude decreases as exp(-c t/2). More damping
#   shortens the time.
# - If ζ = 1, the damping is critical. The distance from equilibrium is (1 + ω t) exp(-ω t).
# - If ζ > 1, the mode creeps. Far above 1, the distance decreases as exp(-ω² t/c). More damping
#   lengthens the time.
#
# A body has many modes and one damping rate. The rate that is critical for the slowest mode is
# below critical for all others, which vibrate. Their amplitudes decrease as exp(-c t/2) all the
# same, whatever their frequency. So the slowest mode decides. More precisely, it is the slowest
# mode that the load excites.
#
# The experiment
# --------------
#
# A square block has particles that are 1 m apart, with 1 kg per cell. Its springs have k1 = 1 N/m
# and k2 = 1/2 N/m. The left and the lower side are on rollers, and a traction pulls the right side.
# ``algorithm1`` integrates the motion by Euler-Cromer from the undeformed state, until the residual
# force and the velocities are negligible. It tests for convergence every 20 steps.
#
# The time step is 0.2 s in all runs, a quarter of the critical time step. The number of steps is
# then proportional to the time.

import matplotlib.pyplot as plt
import numpy as np

import msvalidate as ms

# %%
# Steps over the damping ratio
# ----------------------------
#
# Where do you expect the minimum? Which slopes do the two branches have on logarithmic axes? The
# second block has twice as many cells a side: how does its curve differ?

ratios = np.geomspace(0.1, 10, 13)
for cells in 5, 10:
    problem = ms.body(
        ms.Box(cells, cells),
        ms.Isotropic(4 / 3, 1 / 3, density=1),
        fixed={"left": (0, None), "bottom": (None, 0)},
        traction={"right": (1e-3, 0)},
    )
    network = ms.build(problem, cells=cells)
    slowest = ms.natural_frequencies(network, 1).lowest[0]  # rad/s
    runs = [ms.algorithm1(network, dt=0.2, damping=2 * zeta * slowest) for zeta in ratios]
    steps = [run.steps for run in runs]
    plt.loglog(ratios, steps, "o-", label=f"{cells} x {cells} cells")
    print(f"{slowest:.3f} rad/s; {min(steps)} steps at {ratios[np.argmin(steps)]:.2f}")
plt.axvline(1, color="k", linestyle=":", label="critical damping of the slowest mode")
plt.xlabel("damping ratio of the slowest mode")
plt.ylabel("steps to equilibrium")
plt.legend(loc="lower right")

# %%
# Reading the curves
# ------------------
#
# The left branch has the slope -1, as expected from exp(-c t/2). Three times the damping takes a
# third of the time. The right branch has the slope 1 far from the minimum, as expected from
# exp(-ω² t/c). The minimum lies a little below critical damping. There, the slowest mode
# overshoots once, by less than the tolerance.
#
# Overdamping is sometimes recommended if the critical value is unknown. The curve refutes this
# advice. For 5 x 5 cells, the damping ratio 1/3 takes 1060 steps and the ratio 3 takes 1960.
#
# Overdamping has a second cost. Euler-Cromer evaluates the viscous force with the old velocity.
# If c h is close to 2, a step nearly reverses the velocity. The motion is stable as long
# as c h/2 + h² ω²/4 is less than 1, with the highest natural frequency ω. Here this limit is
# c = 9.4 1/s, or a damping ratio of 15.
#
# The second block has half the natural frequency, and it takes twice as many steps at every damping
# ratio. The steps have the same length, since the highest frequency is nearly the same.
#
# Exercises
# ---------
#
# 1. How many steps does the damping ratio 0.9 take for 20 x 20 cells? Predict the number from the
#    ratios of the two curves.
# 2. N points form a square lattice. How does the work of dynamic relaxation grow with N at the
#    best damping? Does the relaxation take a "limited and constant" time, as has been claimed?
# 3. You know neither the frequencies nor the best damping. Compare
#    ``ms.relax(network, "kinetic_damping").steps`` with the minimum of the curve.
# 4. Pull the block at one corner only, by a point force. Does the best damping ratio change?

# %%
# Answers
# -------
#
# 1. It takes 1660 steps. The numbers for 5, 10 and 20 cells a side are 400, 820 and 1660, so that
#    they double with the number of cells.
# 2. The number of steps grows as the square root of N, because the lowest natural frequency is
#    proportional to 1/√N. The work of one step is proportional to N, and the total to N to the
#    power 1.5. The time is not constant.
# 3. Kinetic damping takes 160 steps for 5 x 5 cells and 300 for 10 x 10 cells. It removes the
#    velocities whenever the kinetic energy passes a maximum. It needs no damping rate, and it takes
#    0.9 of the critical time step.
# 4. Slightly. The best ratio is about 1 in place of 0.95, and it takes 360 steps in place of 400
#    for 5 x 5 cells. The best damping depends on the modes that the load excites.
