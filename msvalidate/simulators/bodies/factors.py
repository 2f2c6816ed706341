"""Why an answer is larger than elasticity's: law, resolution, mass, solver, and what is left.

The causes come apart by construction. Each displacement differs from the one before it by one
cause alone: elasticity as asked; elasticity of what the law is to first order; linear elements of
that law on the program's own mesh; the same with the masses that were measured; the program as far
as it can be brought to rest; the program as it was run. A factor is the quotient of two sizes that
follow one another, so all of them multiply to the whole.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from msvalidate.simulators.bodies.blocks import AtRest, elasticity_at

UNEXPLAINED = 0.01
"""Part of the displacement that may be left where causes explain an answer."""


@dataclass(frozen=True)
class Factors:
    """What each cause multiplies the displacement by, 1 where it does nothing.

    Parameters
    ----------
    total
        Size of the answer over that of elasticity as asked.
    law, resolution, mass, solver
        Of each cause.
    left
        What the causes do not explain: the program brought to rest over the elements that should be
        alike.
    apart
        Largest difference of these two over the largest displacement, of whatever shape.
    """

    total: float
    law: float
    resolution: float
    mass: float
    solver: float
    left: float
    apart: float

    @property
    def is_explained(self) -> bool:
        """Whether what is left, in size and in shape, is small."""
        return self.apart <= UNEXPLAINED


def factors(
    found: AtRest,
    law: tuple[float, float],
    mass: Array | None = None,
    settled: AtRest | None = None,
) -> Factors:
    """Take the causes of an answer apart.

    Parameters
    ----------
    found
        The answer as the program was run.
    law
        Modulus (Pa) and ratio of its law to first order, as probed, or as its documents say.
    mass
        (n,) kg as measured; None where they are those asked.
    settled
        The answer with steps and iterations at which nothing changes any more; None where it is
        the same.

    Raises
    ------
    ProblemError
        If the set does not reach to the ratio asked for.
    """
    case, asked = found.case, found.request.material
    named = case.named
    wanted = elasticity_at(case, 1.0, asked.nu)
    on_mesh = found.of_elements(*law)
    own_law = _elasticity_of(found, law, on_mesh)
    weighed = on_mesh if mass is None else found.of_elements(*law, mass)
    rest = found if settled is None else settled

    def size(move: Array) -> float:
        return float((move * wanted).sum() / (wanted * wanted).sum())

    sizes = [
        size(wanted), size(own_law), size(on_mesh[named]), size(weighed[named]),
        size(rest.move[named]), size(found.move[named]),
    ]  # fmt: skip
    steps = [after / before if before else np.inf for before, after in pairwise(sizes)]
    away = np.linalg.norm(rest.move - weighed, axis=1).max()
    apart = float(away / np.linalg.norm(weighed, axis=1).max())
    return Factors(sizes[-1], steps[0], steps[1], steps[2], steps[4], steps[3], apart)


def _elasticity_of(found: AtRest, law: tuple[float, float], on_mesh: Array) -> Array:
    """(p, 3) m of elasticity of a law.

    Below the ratios of the set what it is to the nearest of them, elements are on the same mesh;
    above them it is that of the nearest, as elements lock there. What that is off by goes from
    "law" to "resolution", and nothing of it into what is left.
    """
    case, asked = found.case, found.request.material
    E, nu = law
    near = float(np.clip(nu, *case.ratios))
    known = elasticity_at(case, E / asked.E, near)
    if near <= nu:
        return known
    return np.asarray(known + (on_mesh - found.of_elements(E, near))[case.named])
