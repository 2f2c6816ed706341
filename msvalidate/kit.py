"""All that a study needs, in one import: ``from msvalidate import kit``.

What is asked (`msvalidate.problem`), candidates, evidence and its rules, words of columns,
settings, the judge's arithmetic, and figures. Solvers are imported from where they are.
"""

from msvalidate.bench.judging.candidate import (
    Answer,
    DisplacementSolver,
    check_actuator,
    check_displacements,
    check_functions,
    check_motion,
    check_table,
    solve_springs,
)
from msvalidate.bench.judging.columns import Column
from msvalidate.bench.judging.columns import read_columns as columns
from msvalidate.bench.judging.compare import (
    Observed,
    Tolerance,
    farthest_value,
    fitted_power,
    observed_order,
)
from msvalidate.bench.judging.evidence import Evidence, Tables, gather_evidence, merge
from msvalidate.bench.judging.rules import Difference, Quotient, Rule
from msvalidate.bench.judging.summary import summary_row, summary_tables
from msvalidate.bench.judging.sweep import FULL, Setting
from msvalidate.bench.output import body_drawing, drawing, figures
from msvalidate.bench.output.drawing import field, series
from msvalidate.bench.output.results import Results, check_results
from msvalidate.problem import *  # noqa: F403  its __all__: what is asked
from msvalidate.springs.network import Network
