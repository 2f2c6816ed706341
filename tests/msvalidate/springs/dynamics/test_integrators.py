"""Each scheme by its own one-step matrix: limit, areas, energy; the misprints measured."""

import numpy as np
import pytest
from msvalidate.studies.stability.matrices import MATRICES

from msvalidate.problem import ProblemError
from msvalidate.springs.dynamics.integrators import INTEGRATORS, LEAPFROG, step_factors
from msvalidate.springs.dynamics.step_limits import one_step_matrix, stability_limit

every_scheme = pytest.mark.parametrize("name", INTEGRATORS)
LIMITED = [name for name, scheme in INTEGRATORS.items() if scheme.limit(0.0) < np.inf]
limited_schemes = pytest.mark.parametrize("name", LIMITED)
unlimited_schemes = pytest.mark.parametrize("name", set(INTEGRATORS) - set(LIMITED))
OMEGA = 2.0
ZETAS = (0.0, 0.05, 0.3, 0.7, 1.0, 1.5, 2.0, 10.0)


def growth_factor(scheme, omega, h, damping):
    """Largest factor by which a mode can grow in a step."""
    return np.abs(np.linalg.eigvals(one_step_matrix(scheme, omega, h, damping))).max()


@limited_schemes
@pytest.mark.parametrize("zeta", ZETAS)
def test_limits_are_where_the_matrix_says(name, zeta):
    """Stable over the whole range below the limit, unstable just above it."""
    scheme, damping = INTEGRATORS[name], 2 * zeta * OMEGA
    limit = stability_limit(scheme, OMEGA, OMEGA, damping)
    # Undamped, a symplectic scheme's eigenvalues lie on the circle to rounding.
    for part in [*np.linspace(0.01, 0.999, 60), 1 - 1e-6]:
        assert growth_factor(scheme, OMEGA, part * limit, damping) <= 1 + 1e-12 if limit else True
    above = (1 + 1e-6) * limit or 1e-3
    assert growth_factor(scheme, OMEGA, above, damping) > 1 + 1e-9


@unlimited_schemes
@pytest.mark.parametrize("zeta", ZETAS)
def test_what_has_no_limit_is_stable_at_any_step(name, zeta):
    scheme, damping = INTEGRATORS[name], 2 * zeta * OMEGA
    assert stability_limit(scheme, OMEGA, OMEGA, damping) == np.inf
    for h in np.geomspace(1e-3, 1e4, 30):
        assert growth_factor(scheme, OMEGA, h, damping) <= 1 + 1e-12


@limited_schemes
@pytest.mark.parametrize("damping", [0.05, 1.0, 7.0])
def test_the_ends_bound_every_mode_between(name, damping):
    scheme = INTEGRATORS[name]
    limit = stability_limit(scheme, 0.1, 5.0, damping)
    for omega in np.geomspace(0.1, 5.0, 60):
        assert growth_factor(scheme, omega, 0.999 * limit, damping) <= 1 + 1e-12


@pytest.mark.parametrize(("h", "c"), [(0.01, 0.0), (0.3, 0.0), (0.3, 0.7), (1.5, 4.0)])
def test_a_step_is_that_of_its_matrix_on_paper(h, c):
    assert set(MATRICES) == set(INTEGRATORS)
    for name, on_paper in MATRICES.items():
        found = one_step_matrix(INTEGRATORS[name], 1.0, h, c)
        np.testing.assert_allclose(found, on_paper(h, c), atol=1e-14)


@every_scheme
@pytest.mark.parametrize("h", [0.01, 0.3])
def test_symplectic_schemes_keep_areas(name, h):
    scheme = INTEGRATORS[name]
    area = np.linalg.det(one_step_matrix(scheme, OMEGA, h))
    assert (abs(area - 1) < 1e-14) == scheme.symplectic


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((2.0, 1.0), ProblemError, "from 2 to 1 rad/s; give the lowest first"),
        ((0.0, 1.0), ProblemError, "lowest frequency"),
        ((1.0, np.nan), ProblemError, "highest frequency"),
        ((1.0, 1.0, -1.0), ProblemError, "a negative rate feeds the motion"),
    ],
)
def test_limits_of_what_is_none(arguments, error, message):
    with pytest.raises(error, match=message):
        stability_limit(INTEGRATORS["leapfrog"], *arguments)


def test_a_scheme_is_chosen_by_its_name():
    assert step_factors("leapfrog") is LEAPFROG.factors
    with pytest.raises(ProblemError, match="scheme: 'leap'; did you mean 'leapfrog'"):
        step_factors("leap")
