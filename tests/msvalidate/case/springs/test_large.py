"""`springs.large`: a finer mesh changes the displacements by less than their stated uncertainty."""

import numpy as np

from msvalidate.case.springs.large import BY_NAME, change_in_full
from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.problem.records import replace
from reference_fem.converged import converge


def test_the_uncertainty_of_changes_covers():
    """Cantilevers at random, in m and mm: at least 95 of 100."""
    rng = np.random.default_rng(1)
    law, covered = next(iter(BY_NAME.values())), []
    for size in (0.37, 370.0) * 2:
        box = Box((rng.uniform(1, 3) * size, size))
        clamp = Support(box.side("left"), (0.0, 0.0))
        pull = Traction(box.side("right"), tuple(rng.uniform(-1e3, 1e3, 2).tolist()))
        material = Isotropic(1e5, rng.uniform(0, 0.45), thickness=0.2)
        places = rng.uniform(0.1, 1, (20, 2)) * box.size
        problem = Problem(box, material, (clamp,), (pull,))
        reference = converge(problem, places, 1e-9, most_nodes=2500)
        coarse = replace(reference, solutions=reference.solutions[:-1])
        change, finer = (change_in_full(each, law) for each in (coarse, reference))
        away = np.linalg.norm(change.displacement - finer.displacement, axis=1).max()
        covered.append(away <= change.uncertainty < np.inf)
    assert np.mean(covered) >= 0.95
