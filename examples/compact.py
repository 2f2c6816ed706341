"""The source report in 80 lines: Algorithm 1 on 6 x 6 particles, and finite elements beside it."""

import argparse
import sys

import numpy as np
import skfem.models.elasticity

# SI units; particles of 1 kg are 1 m apart, springs along the axes have k1 = 1 N/m.
NUMBERS = {"cells": 5, "k2": 0.5, "pull": 1e-3, "damping": 0.5, "step": 0.2}
# Parts of the force in dv and of dv in dx. As section 5.4 prints them, Euler-Cromer is Euler and
# Verlet has half the force; leap frog is the loop of Algorithm 1.
INTEGRATORS = {"algorithm1": (1, 1), "euler": (1, 0), "euler-cromer": (1, 0), "verlet": (0.5, 1)}


def lattice(cells, k2, whole):
    """Springs: their ends in the grid of particles, stiffness. A cell brings half of its sides."""
    sw, se, nw, ne = np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[:-1, 1:], np.s_[1:, 1:]  # of every cell
    edge = [(np.s_[:-1, ::cells], np.s_[1:, ::cells]), (np.s_[::cells, :-1], np.s_[::cells, 1:])]
    sides = [(sw, se), (nw, ne), (sw, nw), (se, ne)] + edge * whole  # which has but one cell beside
    return [(a, b, 1 / 2) for a, b in sides] + [(sw, ne, k2), (se, nw, k2)]


def algorithm1(cells, k2, pull, damping, step, integrator="algorithm1", whole=False):
    """Yield the particles' displacement (n, n, 2) in m, step after step until they are at rest."""
    x0 = x = np.stack(np.indices((cells + 1, cells + 1), dtype=float), axis=-1)
    v, external, free = np.zeros_like(x), np.zeros_like(x), np.ones_like(x)
    external[-1, :, 0], external[-1, [0, -1], 0] = pull, pull / 2  # a corner has half a face
    free[0, :, 0] = free[:, 0, 1] = 0  # the left and the lower side slide
    springs, (kick, drift) = lattice(cells, k2, whole), INTEGRATORS[integrator]
    rest = max(1e-11 * pull, 2.2e-16 * cells * max(4, 4 * k2, 0.5 / step))  # k x, x / step round
    for steps in range(50_000):
        force = external - damping * v
        for a, b, k in springs:
            d, d0 = x[b] - x[a], x0[b] - x0[a]
            f = k * (1 - np.linalg.norm(d0, axis=-1) / np.linalg.norm(d, axis=-1))[..., None] * d
            force[a] += f
            force[b] -= f
        force *= free
        yield x - x0
        left = max(abs(v).max(), abs(force).max())
        if steps and left < rest:  # the report looks at v alone, and before the first step
            return
        if not left < 1e3:
            raise ArithmeticError(f"unstable after {steps} steps: reduce --step")
        dv = step * kick * force  # m = 1
        x, v = x + step * (v + drift * dv), v + dv
    raise ArithmeticError(f"not at rest after {steps} steps: still {left:.1g} m/s or N")


def elements(cells, k2, pull, **_):
    """Displacement of the same by quadratic elements in plane stress, lambda = k2, mu = k1/2."""
    mesh = skfem.MeshQuad.init_tensor(*[np.arange(cells + 1.0)] * 2).with_defaults()
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()))
    stiffness = skfem.models.elasticity.linear_elasticity(k2, 1 / 2).assemble(basis)
    load = skfem.LinearForm(lambda v, _: pull * v[0]).assemble(basis.boundary("right"))
    held = np.append(basis.get_dofs("left").all("u^1"), basis.get_dofs("bottom").all("u^2"))
    u = skfem.solve(*skfem.condense(stiffness, load, D=held))
    return u[basis.nodal_dofs].T.reshape(cells + 1, cells + 1, 2)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(None, argparse.SUPPRESS, __doc__, allow_abbrev=False)
    for name, n in NUMBERS.items():
        parser.add_argument(f"--{name}", type=type(n), default=n, help=f"default {n}, at most 20")
    parser.add_argument("--integrator", choices=INTEGRATORS, default="algorithm1")
    parser.add_argument("--whole", action="store_true", help="whole springs on the edge, not half")
    o = vars(parser.parse_args())
    if not all(0.001 <= o[name] <= 20 for name in NUMBERS):
        parser.error(f"{', '.join(NUMBERS)} must be numbers from 0.001 to 20")
    try:
        k2, elastic, (*_, (steps, u)) = o["k2"], elements(**o), enumerate(algorithm1(**o))
    except ArithmeticError as error:
        parser.exit(3, f"{parser.prog}: {error}\n")
    nu = [-w[:, -1, 1].mean() / w[-1, :, 0].mean() for w in (u, elastic)]
    strain, difference = elastic.max() / o["cells"], abs(u - elastic).max() / abs(elastic).max()
    sys.stdout.write(f"""at rest after {steps} steps
ratio of the springs {nu[0]:.4f}, of the elements {nu[1]:.4f}
k2/(2 k1 + k2) = {k2 / (2 + k2):.4f} for one cell, k2/(k1 + k2) = {k2 / (1 + k2):.4f} for a lattice
springs beside elements: {difference:.1e} of the largest displacement, at strain {strain:.1e}\n""")
