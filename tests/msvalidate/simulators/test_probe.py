"""The probe on laws made here: what it reads, and what it must not let count."""

import numpy as np
import pytest

from msvalidate.problem import Isotropic, ProblemError
from msvalidate.simulators.exchange.protocol import Answer, SimulatorError
from msvalidate.simulators.probe.block import Block, probe_mesh
from msvalidate.simulators.probe.masses import Masses
from msvalidate.simulators.probe.probe import probe
from msvalidate.simulators.probe.reading import BAND, anisotropy
from msvalidate.simulators.verdict.sentences import text_of
from tests.msvalidate.simulators.little import (
    Little,
    Springs,
    Tetrahedra,
    isotropic,
    lame,
    linear,
    lumped,
)
from tests.table import table

E0 = 1e7
ASKED = Isotropic(E0, 0.3, "solid")
MU, LAM = lame(E0, 0.3)


def neo_hookean(mu, lam, rest=0.0):
    def stress(F):
        G, J = np.linalg.inv(F).transpose(0, 2, 1), np.linalg.det(F)[:, None, None]
        return F.dtype.type(mu) * (F - G) + F.dtype.type(lam) * np.log(J) * G + rest * J * G

    return stress


def smith(mu, lam):
    def stress(F):
        kind = F.dtype.type
        J, trace = np.linalg.det(F)[:, None, None], (F * F).sum(axis=(1, 2))[:, None, None]
        G = np.linalg.inv(F).transpose(0, 2, 1)
        return (
            kind(mu) * (1 - 1 / (trace + 1)) * F + (kind(lam) * (J - 1) - kind(0.75 * mu)) * J * G
        )

    return stress


def corotated(mu, lam):
    def stress(F):
        U, s, V = np.linalg.svd(F)
        e = (V.transpose(0, 2, 1) * (s - 1)[:, None]) @ V
        trace = np.trace(e, axis1=1, axis2=2)[:, None, None]
        unit = np.eye(3, dtype=F.dtype)
        return (U @ V) @ (F.dtype.type(2 * mu) * e + F.dtype.type(lam) * trace * unit)

    return stress


def saint_venant(mu, lam):
    def stress(F):
        unit = np.eye(3, dtype=F.dtype)
        green = (F.transpose(0, 2, 1) @ F - unit) / 2
        trace = np.trace(green, axis1=1, axis2=2)[:, None, None]
        return F @ (F.dtype.type(2 * mu) * green + F.dtype.type(lam) * trace * unit)

    return stress


def orthotropic():
    """E of 10, 4 and 2 MPa along the axes, three shear moduli, three ratios."""
    S = np.diag([1 / 10, 1 / 4, 1 / 2, 1 / 1.1, 1 / 1.9, 1 / 2.7])
    S[0, 1] = S[1, 0] = -0.3 / 10
    S[0, 2] = S[2, 0] = -0.2 / 10
    S[1, 2] = S[2, 1] = -0.25 / 4
    return np.linalg.inv(S) * 1e6


def young(mu, lam):
    return mu * (3 * lam + 2 * mu) / (lam + mu), lam / 2 / (lam + mu)


NEARLY = lame(E0, 0.49)
# Law -> (stress, its C worked by hand, its E and nu where they exist)
LAWS = {
    "isotropic": (linear(isotropic(MU, LAM)), isotropic(MU, LAM), (E0, 0.3)),
    "orthotropic": (linear(orthotropic()), orthotropic(), None),
    "no shear modulus": (linear(isotropic(0, 2e7)), isotropic(0, 2e7), "shear modulus vanishes"),
    "negative shear": (linear(isotropic(-2e6, 2e7)), isotropic(-2e6, 2e7), "shear modulus is neg"),
    "auxetic": (linear(isotropic(*lame(E0, -0.4))), isotropic(*lame(E0, -0.4)), (E0, -0.4)),
    "nearly incompressible": (neo_hookean(*NEARLY), isotropic(*NEARLY), (E0, 0.49)),
    "Smith, raw Lamé": (
        smith(MU, LAM),
        isotropic(0.75 * MU, LAM - 0.625 * MU),
        young(0.75 * MU, LAM - 0.625 * MU),
    ),
    "corotated": (corotated(MU, LAM), isotropic(MU, LAM), (E0, 0.3)),
    "Saint Venant-Kirchhoff": (saint_venant(MU, LAM), isotropic(MU, LAM), (E0, 0.3)),
    "rotation alone": (corotated(MU, 0), isotropic(MU, 0), (2 * MU, 0.0)),
}
# C by its largest component, E relative, nu: half a percent is asked in single precision.
ASKED_FOR = {"float64": (1e-6, 1e-6, 1e-6), "float32": (5e-3, 5e-3, 5e-3)}
EVERY = [(law, *how) for law in LAWS for how in (("float64", False), ("float32", True))]


def read(stress, kind="float64", implicit=False, material=ASKED, **faults):
    little = Little(lambda mesh, k: Tetrahedra(mesh, stress, k), implicit, kind, **faults)
    return probe(little, material)


def failed(reading):
    return {flag.name for flag in reading.flags if flag.refuses and not flag.holds}


@table("law, kind, implicit", EVERY)
def test_laws_are_read(law, kind, implicit):
    stress, C, expected = LAWS[law]
    reading = read(stress, kind, implicit)
    assert reading.is_valid, reading.refusals()
    largest, (of_C, of_E, of_nu) = np.abs(C).max(), ASKED_FOR[kind]
    off = np.abs(reading.C - C).max()
    assert off < of_C * largest
    assert off < reading.error  # what it says of itself
    if isinstance(expected, str):
        assert reading.E is reading.nu is None
        assert expected in text_of(reading.elastic.because)
    elif expected:
        assert pytest.approx(expected[0], rel=of_E) == reading.E
        assert reading.nu == pytest.approx(expected[1], abs=of_nu)
        assert abs(reading.E - expected[0]) < reading.elastic.E_error
        assert abs(reading.nu - expected[1]) < reading.elastic.nu_error


def test_an_anisotropic_reading_says_so():
    assert anisotropy(read(LAWS["orthotropic"][0]).C) > BAND
    assert anisotropy(read(linear(isotropic(MU, LAM))).C) < 1e-9


def test_reading_springs_is_a_bound():
    little = Little(lambda mesh, kind: Springs(mesh, 1e4, kind))
    reading = probe(little, ASKED)
    assert reading.is_bound
    assert reading.E is None
    assert "upper bound" in text_of(reading.elastic.because)
    assert failed(reading) == {"force on inner nodes"}
    implicit = Little(lambda mesh, kind: Springs(mesh, 1e4, kind), implicit=True)
    assert probe(implicit, ASKED).is_bound
    stiffer = probe(Little(lambda mesh, kind: Springs(mesh, 1e7, kind)), ASKED)
    inner, same = (
        next(flag.value for flag in one.flags if flag.name == "force on inner nodes")
        for one in (reading, stiffer)
    )
    assert same == pytest.approx(inner, rel=1e-6)
    assert min(stiffer.causes[part] for part in ("resultant", "C not symmetric")) > 0


BLOCK = Block(probe_mesh(), ASKED)


def floor(x):
    """A floor that pushes what is below -0.06 m."""
    f = np.zeros_like(x)
    f[:, 2] = 1e5 * np.maximum(-0.06 - x[:, 2], 0)
    return f


def squeeze(x):
    """Repulsion between two opposite nodes, as of particles with a radius."""
    f = np.zeros_like(x)
    f[0], f[-1] = -20.0, 20.0
    return f


def kinked(F):
    """A law that pushes one way, whether it is pulled or pressed."""
    change = np.abs(np.trace(F - np.eye(3), axis1=1, axis2=2))
    return linear(isotropic(MU, LAM))(F) + MU / 2 * change[:, None, None] * np.eye(3)


FAULTS = {
    "second-order part": (kinked, {}),
    "stress at rest": (neo_hookean(MU, LAM, rest=0.01 * MU), {}),
    "forces at rest": (linear(isotropic(MU, LAM)), {"outside": squeeze}),
    "damping": (linear(isotropic(MU, LAM)), {"keep": 0.99}),
    "half the step, another strain": (
        linear(isotropic(MU, LAM)),
        {"implicit": True, "viscous": 1e-5},
    ),
    "asked again": (linear(isotropic(MU, LAM)), {"remember": 0.01}),
}


@table("name", FAULTS)
def test_faults_are_flagged(name):
    stress, faults = FAULTS[name]
    try:
        reading = read(stress, **faults)
    except SimulatorError as error:
        pytest.fail(str(error))
    assert name in failed(reading)
    assert reading.E is None
    assert name in text_of(reading.elastic.because)


def test_a_floor_is_refused():
    with pytest.raises(SimulatorError, match="masses"):
        read(linear(isotropic(MU, LAM)), outside=floor)


def test_contact_on_one_side_is_flagged_where_masses_are_given():
    own = lumped(probe_mesh(), ASKED.density)
    masses = Masses(own, np.ones(len(own)), 0.0, "given", np.array([], dtype=int), own)
    body = Little(lambda mesh, k: Tetrahedra(mesh, linear(isotropic(MU, LAM)), k), outside=floor)
    assert {"net force", "forces at rest"} <= failed(probe(body, ASKED, masses=masses))


def test_wrong_masses_leave_the_law_as_it_is():
    # The total is asked for: what is read is E over density.
    equal = np.full(80, BLOCK.lumped.sum() / 80)
    reading = read(linear(isotropic(MU, LAM)), masses=equal)
    assert reading.is_valid
    assert pytest.approx(E0, rel=1e-6) == reading.E
    assert "equal masses on all nodes" in text_of(reading.masses.line)
    assert [flag.name for flag in reading.flags if not flag.holds] == ["masses"]


@table(
    "E, kind, implicit", [(E, k, i) for E in (1e3, 1e11) for k in ASKED_FOR for i in (False, True)]
)
def test_extremes_of_stiffness_at_density_one(E, kind, implicit):
    material = Isotropic(E, 0.3, "solid", density=1.0)
    reading = read(neo_hookean(*lame(E, 0.3)), kind, implicit, material)
    assert reading.is_valid, reading.refusals()
    assert pytest.approx(E, rel=ASKED_FOR[kind][1]) == reading.E


def test_programs_may_tell_forces_or_a_mass_matrix():
    body = Tetrahedra(probe_mesh(), linear(isotropic(MU, LAM)))
    matrix = BLOCK.consistent.toarray()

    def static(request):
        return Answer(force=body.force(request.start), about={"precision": "float64"})

    def consistent(request):
        v = request.dt * (np.linalg.solve(matrix, body.force(request.start)) + request.gravity)
        about = {"precision": "float64", "forces_at": "start", "mass": "consistent"}
        return Answer(position=request.start, velocity=v, about=about)

    for simulator in (static, consistent):
        reading = probe(simulator, ASKED)
        assert reading.is_valid, reading.refusals()
        assert pytest.approx(E0, rel=1e-6) == reading.E

    def lies(request):
        told = consistent(request)
        return Answer(told.displacement, told.position, told.velocity, None,
                      {**told.about, "mass": "lumped"})  # fmt: skip

    assert failed(probe(lies, ASKED))


def test_what_an_answer_must_say():
    body = Little(lambda mesh, k: Tetrahedra(mesh, linear(isotropic(MU, LAM)), k))

    def silent(request):
        told = body(request)
        about = {key: value for key, value in told.about.items() if key != "forces_at"}
        return Answer(position=told.position, velocity=told.velocity, about=about)

    with pytest.raises(SimulatorError, match="no forces_at; say start or end"):
        probe(silent, ASKED)
    with pytest.raises(ProblemError, match="give state solid"):
        probe(body, Isotropic(E0, 0.3))
