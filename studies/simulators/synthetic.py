"""Simulators with known faults: what the study has to name, with nothing installed."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from msvalidate.simulators.bodies.laws import LAWS, lame
from msvalidate.simulators.bodies.tetrahedra import Stress, of_law, tetrahedra
from msvalidate.simulators.exchange.program import Program
from msvalidate.simulators.exchange.protocol import Answer, Request, Simulator, SimulatorError
from msvalidate.simulators.verdict.causes import CAUSE, NOT_EXPLAINED, OVER_DENSITY, STOPPED
from msvalidate.simulators.verdict.judgement import Judgement
from msvalidate.springs.lattice.edges import mesh_lattice
from msvalidate.springs.network import internal_force, spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate_check.causes import Cause
from msvalidate_check.verdict import NOT_AT_REST

OWN_LAW = "neo-Hookean, log J"
SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"
STIFFER = 1.01
CONVERGED = 0.9
"""Of the way to rest, after the iterations asked for."""
ITERATIONS = 20
STATED = 1e-6
"""Of the displacement, what one that is not at rest says that may still change."""
CRASHED = "the program ended with signal 11"
NEAR = 2e-3
"""Of a cause's number."""
LIMIT = 2.0
"""Seconds that one that hangs is given."""


@dataclass(frozen=True)
class Faulty:
    """A simulator with one fault.

    Parameters
    ----------
    simulate
        It.
    state, kind
        That it must be in, and of a cause that must be told of it; "" where none must.
    value
        Number of that cause, to a thousandth; None where it has none, or any will do.
    of
        Name -> value that the cause must name.
    """

    simulate: Simulator
    state: str
    kind: str = ""
    value: float | None = None
    of: Mapping[str, object] = field(default_factory=dict)

    def is_named_in(self, found: Judgement) -> bool:
        """Whether state and causes name the fault."""
        return found.word == self.state and (
            not self.kind or any(self._is(cause) for cause in found.causes)
        )

    def _is(self, cause: Cause) -> bool:
        sized = self.value is None or abs(cause.value - self.value) <= NEAR
        named = cause.of.values
        return cause.kind == self.kind and sized and all(each in named for each in self.of.items())


def clean(request: Request) -> Answer:
    """Linear tetrahedra of the neo-Hookean law with log J: right in all that is asked here."""
    return _of_law(OWN_LAW)(request)


def clean_implicit(request: Request) -> Answer:
    """The same with implicit steps."""
    settings = {**request.settings, "integrator": "implicit"}
    return clean(replace(request, settings=settings))


def _of_law(name: str) -> Simulator:
    return of_law(name, f"synthetic, {name}")


def _volume_constant(request: Request) -> Answer:
    """λ where the law needs λ + μ."""

    def law_of(asked: Request) -> Stress:
        mu, lam = lame(asked.material.E, asked.material.nu)
        return lambda F: LAWS[OWN_LAW].stress(F, mu, lam - mu)

    return tetrahedra(law_of, "synthetic, lam for lam + mu")(request)


def _stiffer(request: Request) -> Answer:
    material = replace(request.material, E=STIFFER * request.material.E)
    return clean(replace(request, material=material))


def _full_cells(request: Request) -> Answer:
    """The mass of a full cell of a grid on every node, so half too much on a face."""
    corners = len(request.mesh.cells) / 6
    each = request.mass.sum() / corners
    return clean(replace(request, mass=np.full(len(request.mass), each)))


def _full_cells_at_rest(request: Request) -> Answer:
    """The same where it comes to rest alone, so that no motion shows it."""
    return _full_cells(request) if request.task == "rest" else clean(request)


def _half_weight(request: Request) -> Answer:
    """Half the gravity at rest."""
    rest = request.task == "rest"
    return clean(replace(request, gravity=request.gravity / 2) if rest else request)


def _one_way(request: Request) -> Answer:
    """Three tenths more one way than the other, as by a contact or a load that is always there."""
    answer = clean(request)
    if answer.displacement is None:
        return answer
    sign = np.sign((request.force + request.gravity).sum())
    return replace(answer, displacement=(1 + 0.3 * sign) * answer.displacement)


def _half_done(request: Request) -> Answer:
    answer = clean(request)
    if answer.displacement is None:
        return answer
    iterations = int(request.settings.get("iterations", ITERATIONS))
    part = 1 - (1 - CONVERGED) ** (iterations / ITERATIONS)
    size = float(np.linalg.norm(answer.displacement, axis=1).max())
    about = dict(answer.about) | {"settings": {"iterations": [iterations, "1"]}}
    about["at_rest"] = {"change_when_twice_as_long": STATED * size}
    return replace(answer, displacement=part * answer.displacement, about=about)


def _settling(request: Request) -> Answer:
    """The same, which says that as much may still change."""
    answer = _half_done(request)
    if answer.displacement is None:
        return answer
    left = 1.5 * (1 - CONVERGED) * float(np.linalg.norm(answer.displacement, axis=1).max())
    about = dict(answer.about) | {"at_rest": {"change_when_twice_as_long": left}}
    return replace(answer, about=about)


def _over_density(request: Request) -> Answer:
    """Modulus and masses over the density, and forces as they are."""
    rho = request.material.density
    light = replace(request.material, E=request.material.E / rho, density=1.0)
    return _of_law("linear")(replace(request, material=light, mass=request.mass / rho))


def _lying(request: Request) -> Answer:
    answer = _half_done(request)
    return replace(answer, about=dict(answer.about) | {"at_rest": {"residual": 0.0}})


def _swapped(request: Request) -> Answer:
    """Two nodes' rows in each other's place, as when numbers are read from another file."""
    answer = clean(request)
    if answer.displacement is None:
        return answer
    ends = np.argsort(np.linalg.norm(answer.displacement, axis=1), kind="stable")
    one, other = int(ends[-1]), int(ends[len(ends) // 3])
    move = np.array(answer.displacement)
    move[[one, other]] = move[[other, one]]
    return replace(answer, displacement=move)


def _springs(request: Request) -> Answer:
    """A spring k = E h on each edge, h the mean edge, as forums advise: at rest, or in motion."""
    points, edges = request.mesh.points, mesh_lattice(request.mesh).springs
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    network = spring_network(
        points,
        edges,
        request.material.E * float(length.mean()),
        mass=request.mass,
        fixed=request.held,
        displacement=request.value,
        force=request.force + request.mass[:, None] * request.gravity,
    )
    about = {
        "simulator": "synthetic, springs", "version": "1", "precision": "float64",
        "mass": "lumped", "forces_at": "start",
    }  # fmt: skip
    if request.task == "rest":  # to first order: strains are small
        return Answer(displacement=equilibrium(network).displacement, about=about)
    assert request.start is not None  # noqa: S101  as the request checks
    x, v, dt = request.start.copy(), np.zeros_like(request.start), float(request.dt or 0)
    for _ in range(request.steps):
        v = v + dt * (internal_force(network, x) / request.mass[:, None] + request.gravity)
        x = x + dt * v
    return Answer(position=x, velocity=v, about=about)


def _crashing(request: Request) -> Answer:
    raise SimulatorError(CRASHED)


class _Forgetful:
    """One whose state survives: each answer goes on from the last one."""

    def __init__(self) -> None:
        self._asked = 0

    def __call__(self, request: Request) -> Answer:
        answer = clean(request)
        if answer.displacement is None:
            return answer
        self._asked += 1
        return replace(answer, displacement=(1 + 0.02 * self._asked) * answer.displacement)


def _resetting(request: Request) -> Answer:
    """One that goes back to its start where it diverged, and says nothing."""
    answer = clean(request)
    if answer.displacement is None:
        return answer
    return replace(answer, displacement=np.zeros_like(answer.displacement))


def synthetic_faults() -> Mapping[str, Faulty]:
    """Fault -> the simulator that has it, and what has to be said of it."""
    hanging = Program(f'{sys.executable} -c "import time; time.sleep(60)"', LIMIT)
    weighed = {"case": "cantilever_gravity_space"}
    return {
        "lam for lam + mu": Faulty(_volume_constant, CAUSE, "law"),
        "Smith's law, Lamé's constants": Faulty(_of_law(SMITH), CAUSE, "law", 0.7322),
        "a full cell's mass on each node": Faulty(_full_cells, CAUSE, "mass"),
        "a full cell's mass, at rest alone": Faulty(
            _full_cells_at_rest, NOT_EXPLAINED, "body", of=weighed
        ),
        "half the weight at rest": Faulty(_half_weight, NOT_EXPLAINED, "body", of=weighed),
        "one way more than the other": Faulty(_one_way, NOT_EXPLAINED, "one way"),
        "0.9 converged": Faulty(_half_done, STOPPED, "gate", of={"row": "twice the iterations"}),
        "0.9 converged, and says so": Faulty(_settling, NOT_AT_REST, "rest", 0.15),
        "all over the density, but forces": Faulty(
            _over_density, CAUSE, "law", of={"over": OVER_DENSITY}
        ),
        "points swapped": Faulty(_swapped, NOT_EXPLAINED, "body"),
        "1 % too stiff": Faulty(_stiffer, CAUSE, "law", STIFFER),
        "k = E h on each edge": Faulty(_springs, NOT_EXPLAINED, "bound"),
        "states a rest that it is not at": Faulty(_lying, STOPPED, "gate", 0.1),
        "crashes": Faulty(_crashing, STOPPED, "gate failed", of={"because": CRASHED}),
        "hangs": Faulty(hanging, STOPPED, "gate failed"),
        "state survives": Faulty(_Forgetful(), STOPPED, "gate", of={"row": "the same again"}),
        "resets itself": Faulty(_resetting, STOPPED, "gate failed"),
    }


def controls() -> Mapping[str, Simulator]:
    """Faulty simulators that the candidate's own question has to notice."""
    faults = synthetic_faults()
    wanted = (
        "lam for lam + mu", "Smith's law, Lamé's constants", "a full cell's mass on each node",
        "0.9 converged", "points swapped", "1 % too stiff", "k = E h on each edge",
        "state survives", "resets itself", "crashes",
    )  # fmt: skip
    return {name: faults[name].simulate for name in wanted}
