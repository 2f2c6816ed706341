"""
Four integrators and the critical time step
===========================================

Explicit Euler, Euler-Cromer, leapfrog and velocity Verlet advance the same equations of motion.
They differ in one detail: which velocity moves the points, and at which time it is evaluated. This
detail decides whether a simulation is stable. The tutorial compares the four on one mass and one
spring.
"""

# %%
# The four schemes
# ----------------
#
# Let a(x) be the acceleration, h the time step, and n the number of the step.
#
# - **Explicit Euler** uses old values only: x(n+1) = x(n) + h v(n) and v(n+1) = v(n) + h a(x(n)).
# - **Euler-Cromer** updates the velocity first and then moves the points:
#   v(n+1) = v(n) + h a(x(n)), x(n+1) = x(n) + h v(n+1). Other names are semi-implicit Euler and
#   symplectic Euler.
# - **Leapfrog** has the velocities half a step later than the positions.
# - **Velocity Verlet** advances the velocity by half a step and the position by a whole step.
#   Another half step of the velocity follows with the new acceleration.
#
# Each scheme evaluates the forces once per step. Explicit Euler is therefore not cheaper than the
# other three. Euler-Cromer, leapfrog and velocity Verlet move the points in the same way: each
# position follows from the two previous ones by the same rule. They differ in the velocities that
# they report, and in the first step.
#
# The experiment
# --------------
#
# A mass of 1 kg hangs on a spring of 1 N/m and moves along x only. Its natural frequency is
# ω = 1 rad/s. Stretch the spring by 1 mm and release it. There is no damping, so that the energy
# v²/2 + x²/2 remains constant in the exact solution.
#
# ``motion`` advances a `State` and passes each new state to a function ``watch``. The velocities
# that it returns belong to the same time as the positions, for leapfrog too. Predict the energy of
# each scheme before you look at the figure.

import matplotlib.pyplot as plt

import msvalidate as ms

network = ms.spring_network([[0, 0], [1, 0]], [[0, 1]], 1, fixed=[[1, 1], [0, 1]])
critical = 2 / ms.natural_frequencies(network, 1).highest  # s
start = ms.State(1.001 * network.points, 0 * network.points)

# %%
# Critical time step
# ------------------
#
# A step is a linear map of position and velocity. It is stable if no eigenvalue of its matrix
# exceeds 1 in magnitude. For Euler-Cromer, leapfrog and velocity Verlet without damping, the
# critical time step is
#
# .. math:: h_{crit} = \frac{2}{\omega_{max}}.
#
# In a network, the highest natural frequency decides, although its mode shape hardly
# takes part in the motion. For a lattice, the condition has the form of the CFL condition. The
# time step must be shorter than the spacing divided by the speed of pressure waves.
#
# For explicit Euler, both eigenvalues have the magnitude √(1 + h²ω²). It exceeds 1 at every time
# step. The scheme needs damping: with the rate c, it is stable up to h = c/ω² as long as the mode
# is not overdamped.

for scheme in "explicit_euler", "euler_cromer", "velocity_verlet", "leapfrog":
    dt = critical * (1.01 if scheme == "leapfrog" else 0.2)
    states = [start]
    ms.motion(
        network, start, scheme, dt, 20, watch=lambda _, s, to=states: to.append(s), warn=False
    )
    energy = [1e6 * ((s.position - network.points) ** 2 + s.velocity**2).sum() for s in states]
    plt.semilogy(energy, label=f"{scheme}, {dt:.2f} s")
plt.ylim(0.1, 50)
plt.xlabel("step")
plt.ylabel("energy relative to that at the start")
plt.legend(loc="lower left")

# %%
# The energy of each scheme
# -------------------------
#
# The time step of the first three runs is 0.2 of the critical one. The energy of explicit Euler is
# multiplied by 1 + h²ω² = 1.16 in every step, which makes a factor of 19 after 20 steps. A program
# with this scheme needs viscosity merely to hide its own error.
#
# The energy of Euler-Cromer oscillates by about hω/2 = 20 % on either side. It has no trend. The
# scheme is symplectic: it conserves a modified energy that is close to the true one.
#
# The energy of velocity Verlet falls by h²ω²/4 = 4 % and returns. Leapfrog reports the same states
# at this time step. The error of Euler-Cromer is of first order in h, and that of the other two is
# of second order.
#
# The last run is leapfrog at 1.01 of the critical time step. Its energy grows exponentially. At
# 0.99 it is wrong but bounded. There is no gradual transition, so a program should compute the
# limit and not guess it. ``recommended_time_step`` returns 0.9 of it.
#
# Exercises
# ---------
#
# 1. A misprint moves the position of Euler-Cromer with the old velocity. Which scheme results?
#    Run "euler_cromer_as_printed" and compare.
# 2. A second misprint gives Verlet half of the force. A damped network still reaches the correct
#    equilibrium. How can half of the force lead to it, and which results are wrong before?
# 3. A network has ω from 0.25 to 2.5 rad/s and the damping rate 0.5 1/s. Up to which time step is
#    explicit Euler stable?
# 4. You halve the spacing of a 2D lattice of the same material. How do the stiffness, the mass of
#    a point and the critical time step change?

# %%
# Answers
# -------
#
# 1. Explicit Euler. The two energies are equal in every step.
# 2. The force vanishes in equilibrium, and half of zero is zero. Before, the motion is that of a
#    network with twice the masses. Its natural frequencies are lower by √2, and the motion takes
#    longer by √2. Frequencies, velocities and the critical damping are wrong.
# 3. Up to c/ω² = 0.5/2.5² = 0.08 s. The critical time step of undamped leapfrog is 0.8 s, ten times
#    as long. The highest frequency decides, since c/ω² is smallest there.
# 4. The stiffness stays the same, because it is a modulus times the thickness. The mass is a
#    quarter. The highest natural frequency doubles, and the critical time step is halved.
