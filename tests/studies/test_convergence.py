"""The study `convergence`: its counts by other means, what is judged and what is not."""

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.convergence import (
    bodies,
    dynamic_relaxation,
    elimination,
    frontier,
    space,
    spoilt,
    steps,
)
from scipy.sparse import csr_matrix

from msvalidate.bench.judging import counting
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import SolverError
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from reference_fem.systems.direct import node_order

QUICK = Setting(quick=True)


@pytest.fixture(scope="module")
def tables(small_tables):
    return small_tables("convergence")


def test_predicted_steps_are_those_of_a_critically_damped_oscillator():
    """By stepping the slowest mode itself with the leapfrog of the method."""
    root_kappa, threshold = 50.0, 1e-3
    h = 2 * 0.9 / root_kappa  # with omega_min = 1, and so c = 2
    x, v, count = 1.0, 0.5 * h, 0  # at rest: half a kick before the first whole one
    while abs(x) > threshold:
        v = ((1 - h) * v - h * x) / (1 + h)
        x += h * v
        count += 1
    assert counting.predict_steps(root_kappa, threshold) == pytest.approx(count, abs=2)


def test_counts_are_first_times_below_the_threshold():
    """Kinetic damping counted again, step by step."""
    rows = steps.count_steps((RELAXATIONS["kinetic_damping"], "plate", 8))
    (row,) = [row for row in rows if row["threshold"] == 1e-3]
    network, rest = bodies.network("plate", 8), bodies.rest_displacement("plate", 8)
    errors = []

    def watch(run):
        apart = np.hypot(*(run.displacement - rest).T).max() / np.hypot(*rest.T).max()
        errors.append(apart)
        return run.steps >= row["steps"]

    relax(network, RELAXATIONS["kinetic_damping"], tolerance=1e-13, watch=watch, look_every=1)
    assert errors[-1] <= 1e-3 < min(errors[:-1])


def test_growth_of_a_power():
    table = pd.DataFrame(
        {
            "body": "plate",
            "method": "newton",
            "threshold": 1e-6,
            "outcome": ["reached"] * 4 + ["failed"],
            "nodes": [10, 100, 1000, 10000, 100000],
            "steps": [1, 10, 100, 1000, 0],
            "evaluations": [1, 10, 100, 1000, 0],
            "springs": [1, 10, 100, 1000, 10000],
            "root_kappa": [1, 10, 100, 1000, 10000],
        }
    )
    grown = steps.growth(table).set_index("quantity")
    assert grown.loc["steps in nodes", "exponent"] == pytest.approx(1)
    assert grown.loc["steps in kappa", "exponent"] == pytest.approx(0.5)
    assert "cost in nodes" not in grown.index, "Newton's evaluations are not its work"
    grown = steps.growth(table.assign(method="fire")).set_index("quantity")
    assert grown.loc["cost in nodes", "exponent"] == pytest.approx(2)


def test_reproduced_counts_do_not_hang_on_the_last_digits(monkeypatch):
    """The others do: FIRE's by a fifth."""
    network = bodies.network("beam", 4)
    for method in steps.REPRODUCED:
        case = (RELAXATIONS[method], "beam", 4)
        plain = [row["steps"] for row in steps.count_steps(case)]
        factor = 1 + 1e-14 * np.random.default_rng(1).normal(size=len(network.springs))
        monkeypatch.setattr(bodies, "network", lambda *_, f=factor: network.scaled(f))
        assert [row["steps"] for row in steps.count_steps(case)] == plain
        monkeypatch.undo()


def test_a_method_that_fails_is_a_row_that_says_so():
    lagged = spoilt.FAULTS["a lagged force"][1]["viscous_leapfrog"]
    rows = steps.count_steps((lagged, "plate", 8))
    assert [row["outcome"] for row in rows] == ["failed", "failed"]
    row = dynamic_relaxation.count_steps(lagged, 8)
    assert (row["outcome"], row["steps"]) == ("failed", 0)


def test_probes_lie_on_every_lattice():
    for body in bodies.PLANE:
        coarse = frontier.probes(body)
        fine = bodies.network(body, 2 * frontier.COARSEST[body])
        answer, nodes = frontier.solve_springs(
            RELAXATIONS["newton"], body, 2 * frontier.COARSEST[body]
        )
        assert nodes == len(fine.points)
        at = [np.flatnonzero(np.isclose(fine.points, p).all(axis=1))[0] for p in coarse]
        np.testing.assert_allclose(
            answer, bodies.rest_displacement(body, 2 * frontier.COARSEST[body])[at], atol=1e-9
        )


def test_seconds_between_two_sizes():
    rows = pd.DataFrame({"error": [0.1, 0.01, 0.001], "wall_seconds": [1.0, 10.0, 100.0]})
    assert frontier.seconds_to(0.0316227766, rows) == pytest.approx(3.16227766)
    assert frontier.seconds_to(1e-4, rows) is None


def test_damping_that_follows_the_spacing_is_seen_in_space(tables):
    """The plane's rows see it too; here those of the cube must, each by its own limit."""
    table = steps.together("growth", tables)
    spoilt_rows = [
        row
        for edge in steps.QUICK["cube"]
        for row in steps.count_steps((spoilt.BY_SPACING, "cube", edge))
    ]
    spoilt_growth = steps.growth(pd.DataFrame(spoilt_rows))
    kept = table[(table["body"] != "cube") | (table["method"] != "viscous_leapfrog")]
    for grown, seen in ((table, False), (pd.concat([kept, spoilt_growth]), True)):
        judged = [rule.read(steps.split_table("growth", grown)) for rule in steps.CUBE]
        missed = [one.observed.error > one.limit for one in judged]
        assert missed == [*[seen] * 3, *[False] * 3]


def test_growth_that_no_run_reached_is_not_passed(tables):
    nothing = {name: tables[name].iloc[:0] for name in ("growth", "growth_here")}
    for rule in steps.CUBE:
        with pytest.raises(SolverError, match="no row of growth"):
            rule.read(nothing)


def test_counted_factor_is_that_of_dense_elimination():
    """Of a small cube, by eliminating its pattern entry by entry."""
    mesh = space.cube_of_elements(3)
    order = node_order(mesh)
    order = order[space.free_nodes(mesh)[order]]
    pattern = np.kron(mesh.links.toarray()[np.ix_(order, order)] != 0, np.ones((3, 3), dtype=bool))
    for k in range(len(pattern)):
        below = np.flatnonzero(pattern[k:, k]) + k
        pattern[np.ix_(below, below)] = True
    columns = np.tril(pattern).sum(axis=0).astype(float)
    assert space.in_order(mesh, node_order(mesh)) == (columns.sum(), (columns**2).sum())
    every, nodes = elimination.count_full(len(pattern)), len(pattern) // 3
    whole = csr_matrix(np.ones((nodes, nodes)))
    assert every == elimination.count_factor(whole, np.arange(nodes), 3)


def test_elimination_in_layers_is_told_from_nested_dissection(monkeypatch):
    """A band: unknowns^(5/3) entries and unknowns^(7/3) products."""
    limits = {t.quantity: t.limit for t in space.RULES}
    by_layers = [np.lexsort(space.cube_of_elements(n).points.T) for n in space.QUICK_EDGES]
    monkeypatch.setattr(space, "node_order", lambda _: by_layers.pop(0))
    factors = pd.DataFrame([row for n in space.QUICK_EDGES for row in space.count_elimination(n)])
    fits = space.growth(factors).set_index(["way", "quantity"])
    for quantity in ("entries", "products"):
        fit = fits.loc[(space.DISSECTED, quantity)]
        limit = limits[f"cube of elements: exponent of the factor's {quantity} in unknowns"]
        assert abs(fit["exponent"] - fit["expected"]) > limit
