"""The set as one compressed file for the checker."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from cases.make.answer import Answer
from cases.make.files import nodal_meshes, without_rounding
from cases.make.reference import problem_of
from cases.make.statements import SPACE, Statement
from cases.make.versions import read_answers, say
from msvalidate.case.judge.judgement import driven_by

Array = np.ndarray
DIGITS = 12
"""Of masses and forces: as the text files have them."""
MOST = 900_000
"""Bytes: the wheel is to stay below a megabyte."""
DATE = (1980, 1, 1, 0, 0, 0)
"""Of the parts of the archive, so that the same set gives the same bytes."""


def packed_case(
    statement: Statement, answers: dict[float, Answer]
) -> tuple[dict[str, Array], dict[str, Any]]:
    """Arrays of one case by name, and its facts.

    Answers are those of the text files (`versions.read_answers`): version 1's, overlaid by what
    version 2 has.
    """
    name = statement.name
    u = np.array([answer.displacement for answer in answers.values()])
    size = np.linalg.norm(u, axis=2).max(axis=1)
    uncertainty = np.array([answer.uncertainty["displacement"] for answer in answers.values()])
    arrays = {
        f"{name}/displacement": u,
        f"{name}/by_ratio": np.array([a.by_ratio for a in answers.values()], dtype=np.float32),
        f"{name}/uncertainty": uncertainty / size,
    }
    meshes = nodal_meshes(statement)
    for mesh in meshes:
        level = mesh.kind.partition("_")[2] or "1"
        arrays[f"{name}/{level}/points"] = mesh.points
        arrays[f"{name}/{level}/held"] = mesh.held
        arrays[f"{name}/{level}/value"] = mesh.value[mesh.held]
        arrays[f"{name}/{mesh.kind}/cells"] = mesh.cells.astype(np.uint16)
        arrays[f"{name}/{mesh.kind}/mass"] = _rounded(mesh.mass)
        arrays[f"{name}/{mesh.kind}/force"] = _rounded(mesh.force)
        arrays[f"{name}/{mesh.kind}/away"] = np.zeros(u.shape, dtype=np.float16)
        if mesh.problem.zones:
            arrays[f"{name}/{mesh.kind}/modulus"] = mesh.modulus
    for row, nu in enumerate(answers):
        for mesh in nodal_meshes(statement, nu):
            away = (mesh.solution()[: u.shape[1]] - u[row]) / size[row]
            away[np.abs(away) < 1e-9] = 0.0
            arrays[f"{name}/{mesh.kind}/away"][row] = away
    problem = problem_of(statement, statement.own_ratio)
    law = problem.material
    quantities = {
        key: [
            [a.quantities[key].tolist() for a in answers.values()],
            [a.uncertainty[key] for a in answers.values()],
        ]
        for key in next(iter(answers.values())).quantities
    }
    facts = {
        "body": statement.body,
        "state": statement.state,
        "E": law.E,  # type: ignore[union-attr]
        "density": law.density,
        "thickness": 1.0 if statement.state == SPACE else law.thickness,
        "ratios": list(answers),
        "meshes": [mesh.kind for mesh in meshes],
        "case": statement.case_file(statement.own_ratio),
        "driven": driven_by(problem),
        "quantities": quantities,
    }
    return arrays, facts


def _rounded(values: Array) -> Array:
    """Values to as many significant digits as the text files have."""
    kept = without_rounding(values)
    return np.array([float(f"{x:.{DIGITS}g}") for x in kept.ravel()]).reshape(kept.shape)


def pack_set(chosen: Iterable[Statement], folders: tuple[Path, ...]) -> bytes:
    """The checker's file, of the text files of the set: the first folder that has one counts."""
    arrays: dict[str, Array] = {}
    facts: dict[str, Any] = {}
    for statement in chosen:
        own, facts[statement.name] = packed_case(statement, read_answers(statement, folders))
        arrays |= own
        say(f"{statement.name}: packed")
    content = archive(arrays, facts)
    if len(content) > MOST:
        raise ValueError(f"packed {len(content):,} bytes; at most {MOST:,}")
    return content


def archive(arrays: dict[str, Array], facts: dict[str, Any]) -> bytes:
    """An .npz file's content: the same bytes for the same arrays."""
    text = json.dumps(facts, sort_keys=True, separators=(",", ":")).encode()
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        everything = {"facts": np.frombuffer(text, dtype=np.uint8)} | arrays
        for name, array in everything.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.ascontiguousarray(array), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(info, part.getvalue())
    return content.getvalue()
