"""Solutions by springs and by elements, and their comparison, as Python users read them."""

from __future__ import annotations

import html
import math
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bench.output.body_drawing import Drawing, overlay_drawings
from msvalidate.case.compare.quantities import compare_quantities, difference_row, held_by
from msvalidate.case.compare.validity import Limitation, limit_rows, limitations
from msvalidate.case.file.case import BAND, Case
from msvalidate.case.file.schema import QUANTITIES
from msvalidate.case.report.body_plot import mesh_drawing, network_drawings
from msvalidate.case.report.page import quantity_summary
from msvalidate.case.springs.large import BY_NAME, answer_in_full, change_in_full, converge_case
from msvalidate.case.springs.lattice_springs import SpringAnswer, compared_points
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Problem, ProblemError, SolverError
from msvalidate.problem.checks import finite_coordinates
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.zones import spring_shares
from msvalidate.springs.lattice import PatternLattice
from msvalidate.springs.network import Body, Configuration, Network, mode_energy
from msvalidate.springs.statics.contact import ContactEquilibrium
from msvalidate.springs.statics.equilibrium import Equilibrium
from msvalidate.springs.statics.stress import cell_stress, point_stress
from msvalidate_check.text import align_table, number_text
from msvalidate_check.verdict import Difference
from reference_fem.converged import Reference
from reference_fem.first_mesh import first_mesh

LARGE = 0.05
"""Displacement relative to the body's size above which a linear result names its theory."""
HEADS = ("quantity", "value", "unit")
"""Columns of the table of a solution."""


class Result:
    """Base of results: text, HTML and a figure from their rows and drawings."""

    def table(self) -> pd.DataFrame:
        """Return the values, one row per quantity."""
        raise NotImplementedError

    def plot(self, magnification: float | None = None) -> Figure:
        """Plot the deformed body, as the function `plot` does."""
        return overlay_drawings(self.drawings, magnification)

    @property
    def drawings(self) -> list[Drawing]:
        """Lines of the body and their motion."""
        raise NotImplementedError

    @property
    def texts(self) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
        """Heads, rows and sentences as they are shown."""
        table = self.table()
        rows = [
            tuple(number_text(x, 4) if isinstance(x, float) else str(x) for x in row)
            for row in table.itertuples(index=False)
        ]
        return tuple(map(str, table)), rows, []

    def __str__(self) -> str:
        heads, rows, sentences = self.texts
        return "\n".join([*align_table(heads, rows), *sentences])

    def _repr_html_(self) -> str:
        heads, rows, sentences = self.texts
        table = pd.DataFrame(rows, columns=list(heads)).to_html(index=False, border=0)
        return table + "".join(f"<p>{html.escape(sentence)}</p>" for sentence in sentences)


@dataclass(frozen=True, eq=False, kw_only=True)
class SpringSolution(Equilibrium, Result):
    """Equilibrium of a network, with energy, stress, table and plot.

    Parameters
    ----------
    network
        Network that was solved.
    geometry
        "linear" or "nonlinear".
    contact
        Contact with the obstacle, if there is one.
    """

    network: Network
    geometry: Literal["linear", "nonlinear"] = "linear"
    contact: ContactEquilibrium | None = None

    @property
    def energy(self) -> float:
        """Strain energy (J), including that of springs stretched at the reference positions."""
        if self.geometry == "linear":
            change = mode_energy(self.network, self.network.points, self.displacement) / 2
            change -= float((self.network.rest_force * self.displacement).sum())
            return Configuration(self.network).energy() + change
        return Configuration(self.network, self.displacement).energy()

    @cached_property
    def stress(self) -> Array:
        """Stress (n, 3) or (n, 6) in Pa at the points, in Voigt notation.

        Volume-weighted mean of the cells around each point: second order in the spacing at inner
        points, first order on the boundary. Raises `ProblemError` for networks without a lattice,
        or if springs run through no cell.
        """
        body, thickness = self.body, self.body.problem.material.thickness
        options: Any = {"geometry": self.geometry, "thickness": thickness}
        if body.problem.zones:
            options["parts"] = spring_shares(*body)
        cells = cell_stress(self.network, body.lattice, self, **options)
        return point_stress(body.lattice, cells)

    @property
    def body(self) -> Body:
        """Problem and lattice of the network; raises `ProblemError` if it stands for none."""
        body = self.network.body
        if body is None:
            raise ProblemError(
                "springs: this network stands for no problem; build it with build(problem, lattice)"
            )
        return body

    @property
    def answer(self) -> SpringAnswer:
        """Solution as comparisons take it."""
        problem, lattice, constants = self.body
        spacing = lattice.spacing if isinstance(lattice, PatternLattice) else math.nan
        first = constants[0] if isinstance(constants, tuple) else constants
        calibration = first if isinstance(first, Calibration) else None
        solved = self.network, self, calibration, 0.0, self.geometry, self.contact
        return SpringAnswer(problem, spacing, lattice, *solved)

    @property
    def drawings(self) -> list[Drawing]:
        """Springs and their motion."""
        return network_drawings(self.network, self.displacement)

    @property
    def texts(self) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
        """Heads, rows and sentences as they are shown."""
        heads, rows, sentences = super().texts
        part = max_length(self.displacement) / self.network.size
        if self.geometry == "linear" and part > LARGE:
            fact = f"the largest displacement is {number_text(part, 2)} of the body's size"
            sentences = [f"Linear theory: {fact}; compare with elements, or take 'nonlinear'."]
        return heads, rows, sentences

    def table(self) -> pd.DataFrame:
        """Return the largest displacement, the strain energy, reactions and the solver's error."""
        rows = [
            ("largest displacement", max_length(self.displacement), "m"),
            ("strain energy", self.energy, "J"),
        ]
        for support in self.network.body.problem.supports if self.network.body else ():
            force = self.answer.reaction(held_by(support, self.answer))
            rows.append((f"reaction on {support.region}", float(np.linalg.norm(force)), "N"))
        rows.append(("solver error, relative", self.error, ""))
        return pd.DataFrame(rows, columns=list(HEADS))


@dataclass(frozen=True, eq=False)
class ElementSolution(Result):
    """Solution of a problem by finite elements, refined until its error is small.

    Parameters
    ----------
    reference
        Solutions on each mesh, with the points at which they are evaluated.
    geometry
        "linear" or "nonlinear".
    """

    reference: Reference
    geometry: str = "linear"

    @property
    def problem(self) -> Problem:
        """Problem that was solved."""
        return self.reference.problem

    @property
    def points(self) -> Array:
        """Points (p, d) in m at which the solution is evaluated."""
        return self.reference.points

    @property
    def displacement(self) -> Array:
        """Displacement (p, d) in m at the points."""
        return self.reference.displacement.value

    @property
    def error(self) -> float:
        """Largest error of a displacement, relative to the largest displacement."""
        return self.reference.error

    @property
    def energy(self) -> float:
        """Strain energy (J) by linear theory.

        Raises `ProblemError` if the geometry is "nonlinear".
        """
        self._refuse_nonlinear("energy")
        return float(self.reference.energy.value[0])

    @cached_property
    def stress(self) -> Array:
        """Stress (p, 3) or (p, 6) in Pa at the points by linear theory.

        It is in Voigt notation, and has no limit at re-entrant corners. ``reference.stress`` has
        its uncertainties. Raises `ProblemError` if the geometry is "nonlinear".
        """
        self._refuse_nonlinear("stress")
        return self.reference.stress(self.points)[0]

    def _refuse_nonlinear(self, quantity: str) -> None:
        if self.geometry == "nonlinear":
            raise ProblemError(
                f"elements: {quantity} at large displacement is not computed; take "
                "reference(problem), or compare displacements"
            )

    def at(self, points: Array) -> ElementSolution:
        """Return the same solution evaluated at other points (q, d) in m of the body."""
        if np.array_equal(points, self.points):
            return self
        large = self.reference.large
        other = replace(self.reference, points=finite_coordinates("points", points), large=None)
        if large is not None:
            other = replace(other, large=change_in_full(other, BY_NAME[Case.law]))
        return replace(self, reference=other)

    @property
    def drawings(self) -> list[Drawing]:
        """Outline of the coarsest mesh and its motion."""
        mesh = self.reference.solutions[0].body
        lines, moved = mesh_drawing(self.problem, mesh), self.at(mesh.points).displacement
        return [lines._replace(displacement=moved, label="elements")]

    def table(self) -> pd.DataFrame:
        """Return the largest displacement, the strain energy and the relative error."""
        rows: list[tuple[str, float, str]] = [
            ("largest displacement", max_length(self.displacement), "m")
        ]
        if self.geometry == "linear":
            rows.append(("strain energy", self.energy, "J"))
        rows.append(("error of displacements, relative", self.error, ""))
        return pd.DataFrame(rows, columns=list(HEADS))


def solve_elements(case: Case) -> ElementSolution:
    """Solve a case by elements, at the nodes of the coarsest mesh.

    Raises what `converge_case` raises.
    """
    return ElementSolution(converge_case(case, first_mesh(case.problem).points), case.geometry)


@dataclass(frozen=True, eq=False)
class SolutionComparison(Result):
    """Springs compared with finite elements, quantity by quantity.

    Parameters
    ----------
    case
        Problem, tolerance and compared quantities.
    springs, elements
        The two solutions.
    rows
        Differences whose verdicts hold in the range of the theory.
    limitations
        Reasons why a verdict is *not resolved*.
    remarks
        Quantities that were not compared, with the reason.
    """

    case: Case
    springs: SpringSolution
    elements: ElementSolution
    rows: tuple[Difference, ...]
    limitations: tuple[Limitation, ...]
    remarks: tuple[str, ...]

    def table(self) -> pd.DataFrame:
        """Return sizes, relative differences, uncertainties and verdicts."""
        return pd.DataFrame([difference_row(row) for row in self.rows])

    @property
    def texts(self) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
        """Heads, rows and sentences as they are shown."""
        summary = quantity_summary(self.case, self.rows, "springs")
        limits = [each.sentence for each in self.limitations]
        return summary.heads, summary.rows, [summary.caption, *limits, *self.remarks]  # type: ignore[return-value]

    @property
    def drawings(self) -> list[Drawing]:
        """Springs and the outline of the elements."""
        return [*self.springs.drawings, *self.elements.drawings]


def compare(
    springs: SpringSolution, elements: ElementSolution, band: float = BAND
) -> SolutionComparison:
    """Compare springs with finite elements of the same problem.

    The elements are evaluated at the points of the springs, at large displacement if the springs
    were solved so. Outside the range of linear theory no quantity is reported to agree.

    Parameters
    ----------
    springs
        Result of `solve` for a network of `build`.
    elements
        Result of `reference` for the same problem.
    band
        Largest relative difference that counts as agreement.

    Returns
    -------
    SolutionComparison
        Its function ``table`` returns sizes, relative differences, uncertainties and verdicts.

    Raises
    ------
    ProblemError
        If the two solve different problems.
    SolverError
        If elements at large displacement are needed and there are none.

    Examples
    --------
    >>> import msvalidate as ms
    >>> rubber = ms.Isotropic(E=1e5, nu=1 / 3)
    >>> problem = ms.body(ms.Box(0.4, 0.1), rubber, fixed="left", traction={"right": (9, 0)})
    >>> springs = ms.solve(ms.build(problem, cells=8))
    >>> comparison = ms.compare(springs, ms.reference(problem))
    >>> comparison.rows[0].quantity, comparison.rows[0].word
    ('displacement', 'agrees')
    """
    if not (isinstance(springs, SpringSolution) and isinstance(elements, ElementSolution)):
        kinds = f"{type(springs).__name__} and {type(elements).__name__}"
        raise ProblemError(f"compare: {kinds}; give solve(network) and reference(problem)")
    problem, geometry = springs.body.problem, springs.geometry
    if _statement(problem) != _statement(elements.problem):
        raise ProblemError(
            "compare: springs and elements solve two problems; take one problem for "
            "build(problem, lattice) and for reference(problem)"
        )
    quantities = ("displacement",) if geometry == "nonlinear" else QUANTITIES
    case = Case(problem, quantities=quantities, geometry=geometry, band=band)
    answer = springs.answer
    points = compared_points(case, answer.lattice)
    reference = replace(elements.reference, points=points, large=None)
    if not max_length(reference.displacement.value):
        raise ProblemError(
            "compare: nothing moves the points of the springs; give a load, or cells"
        )
    nonlinear = answer_in_full(case, reference)
    if geometry == "nonlinear":
        if nonlinear.target is None:
            raise SolverError(f"compare: no elements at large displacement: {nonlinear.why}")
        reference = replace(reference, large=nonlinear.target)
    rows, remarks = compare_quantities(case, answer, reference)
    missing = [Limitation("quantity", detail=str(each)) for each in remarks if each.failed]
    limits = limitations(case, reference, lambda: nonlinear, None, missing)
    matched = replace(elements, reference=reference, geometry=geometry)
    texts = tuple(str(each) for each in remarks if not each.failed)
    if geometry == "nonlinear":
        texts += ("Forces, energy and stress at large displacement are not compared.",)
    return SolutionComparison(case, springs, matched, limit_rows(rows, limits), limits, texts)


def _statement(problem: Problem) -> tuple[object, ...]:
    """Everything that a problem states except its name."""
    parts = problem.supports, problem.loads, problem.zones, problem.contacts
    return (problem.domain, problem.material, *parts)
