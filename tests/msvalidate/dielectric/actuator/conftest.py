"""Bodies that several test files look at."""

from __future__ import annotations

import pytest

from msvalidate.dielectric.actuator import slab
from msvalidate.dielectric.actuator.models import CHARGES


@pytest.fixture(scope="session", params=[name for name in CHARGES if name != "as_report"])
def body(request):
    """A half covered slab, under every model whose forces are slopes of an energy."""
    return slab(
        4.0,
        1.0,
        4,
        covered=0.5,
        model=request.param,
        depth=2.0,
        permittivity=1.3,
        permittivity_ratio=3.0,
    )


@pytest.fixture(scope="session")
def film():
    """A fully covered film, three times as long as it is high."""
    return slab(12.0, 4.0, 4)


@pytest.fixture(scope="session")
def plates():
    """A film that stays uniform, by the closed forms of which it can be judged."""
    # No wider than it is high: a wide one is pulled in a little earlier, by a wave of four heights.
    return slab(5.0, 10.0, 4, sides="sliding", model="parallel_plates")
