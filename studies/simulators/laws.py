"""Laws: does the probe read what documented laws are to first order?

Question   Laws of soft-body simulators, as their documents or sources have them, take Lamé's
           constants of the E and nu asked for. Which solid are they at small strain, and does one
           step of a simulator of that law show it?
Candidate  Linear tetrahedra of each law by explicit steps, of one by implicit ones too.
Reference  The derivative of the law's stress at rest, by a complex step.
Expected   The two are one: 1e-6 of the largest component of C. Three laws of twelve are another
           solid than the E and nu that they take.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.simulators.bodies.laws import LAWS, lame, predicted
from msvalidate.simulators.bodies.tetrahedra import Stress, tetrahedra
from msvalidate.simulators.exchange.protocol import Request
from msvalidate.simulators.probe.probe import probe
from msvalidate.simulators.probe.reading import SHOWN

from .gaps import ASKED_RATIO, fill_gaps, with_none
from .synthetic import OWN_LAW

E = 1e7
RATIOS = (0.3, 0.45)
COLUMNS = {
    "law": "as `msvalidate.simulators.bodies.laws` names it",
    "source": "where it is documented",
    "steps": "explicit or implicit",
    "asked_ratio": ASKED_RATIO,
    "predicted_modulus": "over the asked, by the documented law to first order",
    "predicted_ratio": "the same for the ratio",
    "read_modulus": "over the asked, as the probe reads it",
    "read_ratio": "the same for the ratio",
    "difference_of_stiffness": "largest of C, over its largest component",
    "stated_error": "of it",
}


def run() -> kit.Evidence:
    """Read every law by both kinds of steps."""
    rows: list[dict[str, object]] = []
    counted = 0
    for name in LAWS:
        for nu in RATIOS:
            for steps in ("explicit", "implicit") if name == OWN_LAW else ("explicit",):
                row, valid = _row(name, nu, steps)
                rows.append(row)
                counted += valid
        table = pd.DataFrame(rows)
    own = (
        kit.Tolerance(
            "laws: largest difference of C as read and as predicted, over its largest component",
            1e-6, "1",
            "two strains of a thousandth leave 1e-12 of the fourth order, rounding 1e-11",
            observed=kit.Observed(float(table["difference_of_stiffness"].max())),
        ),
        kit.Tolerance(
            "laws: readings that do not count", 0, "1",
            "each of them is a solid at rest; a law without shear stiffness is one too",
            observed=kit.Observed(float(len(rows) - counted)),
        ),
        kit.Tolerance(
            "laws: readings whose stated error is too small", 0, "1",
            "the error is stated for the worst of rounding, strain and masses",
            observed=kit.Observed(
                float((table["difference_of_stiffness"] > table["stated_error"]).sum())
            ),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"laws": fill_gaps(table)},
        tolerances=own,
        findings=(_finding(table),),
        columns=with_none(
            COLUMNS, "predicted_modulus", "predicted_ratio", "read_modulus", "read_ratio"
        ),
        rounding=dict.fromkeys(
            ("predicted_modulus", "predicted_ratio", "read_modulus", "read_ratio"), 1e-7
        )
        | {"difference_of_stiffness": 1e-6, "stated_error": 1e-6},
    )


def _finding(table: pd.DataFrame) -> str:
    """Which laws are another solid than what they take."""
    first = table[(table["asked_ratio"] == RATIOS[0]) & (table["steps"] == "explicit")]
    solid = first["predicted_modulus"].notna()
    off = solid & ((first["predicted_modulus"] - 1).abs() > SHOWN)
    told = "; ".join(
        f"{name}: E {E:.3f} times, nu {nu:.3f}"
        for name, E, nu in zip(
            first["law"][off],
            first["predicted_modulus"][off],
            np.round(first["predicted_ratio"][off].to_numpy(float), 3) + 0.0,
            strict=True,
        )
    )
    none = ", ".join(first["law"][~solid])
    return (
        f"Asked for a ratio of {RATIOS[0]:g}, {int(off.sum())} of {len(first)} laws are another "
        f"solid: {told}. No isotropic solid at rest is: {none}."
    )


def _row(name: str, nu: float, steps: str) -> tuple[dict[str, object], bool]:
    def law_of(request: Request) -> Stress:
        mu, lam = lame(request.material.E, request.material.nu)
        return lambda F: LAWS[name].stress(F, mu, lam)

    law = predicted(name, E, nu)
    found = probe(tetrahedra(law_of), kit.Isotropic(E, nu, "solid"), settings={"integrator": steps})
    size = float(np.abs(law.C).max())
    row: dict[str, object] = {
        "law": name,
        "source": LAWS[name].source,
        "steps": steps,
        "asked_ratio": nu,
        "predicted_modulus": np.nan if law.E is None else law.E / E,
        "predicted_ratio": np.nan if law.nu is None else law.nu,
        "read_modulus": np.nan if found.E is None else found.E / E,
        "read_ratio": np.nan if found.nu is None else found.nu,
        "difference_of_stiffness": float(np.abs(found.C - law.C).max()) / size,
        "stated_error": found.error / size,
    }
    return row, found.is_valid
