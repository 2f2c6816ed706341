"""Record what the faults of each study move, so that a failure can be told what it looks like.

    python -m tests.record_faults            # every study, some 15 minutes
    python -m tests.record_faults poisson    # some of them

Writes reports/baseline/faults. Needed when a study's tolerances or faults change.
"""

from __future__ import annotations

import sys

from msvalidate.judging import catalogue
from msvalidate.judging.evidence import judge
from msvalidate.judging.suspects import record_faults
from msvalidate.judging.sweep import Setting
from msvalidate.output.baseline import baseline_folder
from msvalidate.output.stored import csv_bytes
from msvalidate.problem import ProblemError, SolverError


def record(name: str) -> bytes:
    """The table of a study, as CSV; of a fault that stops the study nothing could be told."""
    study, quick = catalogue.load(name), Setting(quick=True)
    spoilt = {}
    for fault, given in study.FAULTS.items():
        try:
            spoilt[fault] = judge(study.run(setting=quick, **given))
        except (ProblemError, SolverError):
            continue
    return csv_bytes(record_faults(judge(study.run(setting=quick)), spoilt))


def main(names: list[str]) -> None:
    """Write the tables of these studies, or of all."""
    folder = baseline_folder("faults")
    folder.mkdir(exist_ok=True)
    for name in names or catalogue.names():
        (folder / f"{name}.csv").write_bytes(record(name))


if __name__ == "__main__":
    main(sys.argv[1:])
