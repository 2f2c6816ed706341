"""Judgements as a JUnit file, which CI servers show: one test case a judged quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol
from xml.etree import ElementTree as ET

import pandas as pd

from msvalidate.bench.judging.evidence import HELD, OPEN


class Suite(Protocol):
    """Judged quantities of one study, case or simulator."""

    @property
    def name(self) -> str:
        """Name of the suite."""

    @property
    def verdict(self) -> pd.DataFrame:
        """Table with a row per judged quantity."""

    @property
    def error(self) -> str:
        """Reason why the suite did not finish, or ""."""

    @property
    def seconds(self) -> float:
        """Duration, s."""


def junit_xml(suites: Sequence[Suite]) -> bytes:
    """Write one test suite per study, case or simulator, as XML.

    A suite that did not finish is an error, and a missed limit a failure. A quantity that is not
    resolved is skipped.
    """
    root = ET.Element("testsuites", name="msvalidate")
    for study in suites:
        rows = [] if study.error else study.verdict.to_dict("records")
        failed = sum(row["verdict"] not in (*HELD, *OPEN) for row in rows)
        left_open = sum(row["verdict"] in OPEN for row in rows)
        suite = ET.SubElement(
            root,
            "testsuite",
            name=study.name,
            tests=str(len(rows) or 1),
            failures=str(failed),
            errors=str(int(bool(study.error))),
            time=f"{study.seconds:.3f}",
        )
        if left_open:
            suite.set("skipped", str(left_open))
        for row in rows:
            case = ET.SubElement(
                suite, "testcase", classname=f"{study.name}.{row['layer']}", name=row["quantity"]
            )
            if row["verdict"] in OPEN:
                said = f"{row['verdict']}: {row['because']}"
                ET.SubElement(case, "skipped", message=printable(said))
            elif row["verdict"] not in HELD:
                failure = ET.SubElement(case, "failure", message=failure_line(row))
                failure.text = printable(row["because"])
        if study.error:
            case = ET.SubElement(suite, "testcase", classname=study.name, name="study finished")
            ET.SubElement(case, "error", message=printable(study.error))
    ET.indent(root)
    return b'<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root) + b"\n"


def printable(text: str) -> str:
    """Text with nothing in it that XML forbids or a terminal obeys."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def failure_line(row: Mapping[Any, Any]) -> str:
    """Describe a failure in one line: value, reference, error, limit and row, or the reason."""
    if row["layer"] == "baseline" or row["error"] != row["error"]:
        return f"{row['quantity']}: {printable(row['because'])}"
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    at = f", at {row['at']}" if row.get("at") else ""
    return (
        f"{row['quantity']}: observed {row['observed']:.9g}, reference {row['reference']:.9g}, "
        f"error {row['error']:.3g} > limit {row['limit']:.3g}{unit}{at}"
    )
