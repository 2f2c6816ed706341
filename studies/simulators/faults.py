"""Faults: is the fault of each faulty simulator named?

Question   Simulators with one known fault each, and clean ones: what is said of them?
Candidate  The synthetic simulators of this study; nothing needs to be installed.
Reference  The fault that was put in.
Expected   Each is named by its state or causes, and none on a clean one.
"""

from __future__ import annotations

import pandas as pd

from msvalidate import kit
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate_check.verdict import AGREES

from .synthetic import Faulty, clean, clean_implicit, synthetic_faults

ASKED = kit.Isotropic(1e7, 0.3, "solid", 1000.0)
MESH = ("tet4",)
COLUMNS = {
    "fault": "what was put in",
    "state_said": "agrees, differs with cause, not at rest, not explained, or gate",
    "said": "the first cause",
    "kinds": "of all causes, rivals among them",
    "named": "whether state and causes name the fault",
}


def run(setting: kit.Setting) -> kit.Evidence:
    """Judge every one."""
    sound = {
        "none": Faulty(clean, AGREES),
        "none, implicit steps": Faulty(clean_implicit, AGREES),
    }
    rows = [_row(name, each) for name, each in (sound | dict(synthetic_faults())).items()]
    table = pd.DataFrame(rows)
    missed = ~table["named"].astype(bool)
    free = table["fault"].str.startswith("none")
    own = (
        kit.Tolerance(
            "faults that are not named", 0, "1", "each changes what a gate or a body shows",
            observed=kit.Observed(float((missed & ~free).sum())),
        ),
        kit.Tolerance(
            "clean simulators that are named", 0, "1", "nothing of them differs",
            observed=kit.Observed(float((missed & free).sum())),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"faults": table},
        tolerances=own,
        findings=(_finding(missed, free),),
        columns=COLUMNS,
    )


def _finding(missed: pd.Series, free: pd.Series) -> str:
    faulty, clean_ones = int((~free).sum()), int(free.sum())
    named, blamed = int((~missed & ~free).sum()), int((missed & free).sum())
    return (
        f"Of {faulty} simulators with a fault {named} are named by it; of {clean_ones} clean ones "
        f"{blamed} are named."
    )


def _row(name: str, faulty: Faulty) -> dict[str, object]:
    found = judge_simulator(faulty.simulate, ASKED, meshes=MESH)
    return {
        "fault": name,
        "state_said": found.word,
        "said": found.causes[0].said if found.causes else "",
        "kinds": ", ".join(dict.fromkeys(each.kind for each in found.causes)),
        "named": faulty.is_named_in(found),
    }
