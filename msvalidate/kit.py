"""All that a study needs, in one import: ``from msvalidate import kit``.

What is asked (`msvalidate.problem`), candidates, evidence and its rules, words of columns,
settings, the judge's arithmetic, and figures. Solvers are imported from where they are.
"""

from msvalidate.judging.candidate import (
    Answer,
    DisplacementSolver,
    check_actuator,
    check_displacements,
    check_functions,
    check_motion,
    check_table,
    solve_springs,
)
from msvalidate.judging.columns import Column
from msvalidate.judging.columns import read_columns as columns
from msvalidate.judging.compare import (
    Observed,
    Tolerance,
    farthest_value,
    fitted_power,
    observed_order,
)
from msvalidate.judging.evidence import Evidence, Tables, gather_evidence, merge
from msvalidate.judging.rules import Difference, Quotient, Rule
from msvalidate.judging.summary import summary_row, summary_tables
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.network import Network
from msvalidate.output import body_drawing, drawing, figures
from msvalidate.output.drawing import field, series
from msvalidate.output.results import Results, check_results
from msvalidate.problem import *  # noqa: F403  its __all__: what is asked
