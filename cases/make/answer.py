"""What a program says of a case at one of Poisson's ratios, and how it is kept on disk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

Array = np.ndarray
WORK = Path(__file__).resolve().parents[2] / "build" / "cases"
"""Answers between the steps that make the set: each takes minutes to an hour in all."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What elasticity says of a statement at one ratio.

    Parameters
    ----------
    displacement, by_modulus, by_ratio
        (p, d) in m at the named points; E ∂u/∂E and ∂u/∂nu.
    quantities
        Name -> values: "reaction 1" (d,) in N, "strain energy" (1,) in J, "mean stress" in Pa.
    uncertainty
        Name -> of every component; of "displacement" in m too.
    order
        Observed order of the displacement; NaN if none.
    nodes
        Of the finest mesh.
    exact
        Whether a formula gave the values, so that all of their digits are written.
    """

    displacement: Array
    by_modulus: Array
    by_ratio: Array
    quantities: dict[str, Array]
    uncertainty: dict[str, float]
    order: float
    nodes: int
    exact: bool = False


def answer_path(who: str, name: str, nu: float) -> Path:
    """Where the answer of `who` on a case at a ratio is kept."""
    return WORK / who / f"{name}_{nu:g}.npz"


def save_answer(path: Path, answer: Answer) -> None:
    """Keep an answer."""
    path.parent.mkdir(parents=True, exist_ok=True)
    names = list(answer.quantities)
    arrays: dict[str, Array] = {f"quantity {name}": answer.quantities[name] for name in names}
    arrays |= {f"uncertainty {k}": np.array(v) for k, v in answer.uncertainty.items()}
    for name in ("displacement", "by_modulus", "by_ratio"):
        arrays[name] = getattr(answer, name)
    new = path.with_suffix(".new.npz")
    np.savez(new, order=answer.order, nodes=answer.nodes, **arrays)  # type: ignore[arg-type]
    new.replace(path)


def load_answer(path: Path) -> Answer:
    """An answer that was kept."""
    with np.load(path) as kept:
        found = {name: kept[name] for name in kept.files}

    def named(start: str) -> dict[str, Array]:
        return {
            key.removeprefix(start): each for key, each in found.items() if key.startswith(start)
        }

    return Answer(
        found["displacement"],
        found["by_modulus"],
        found["by_ratio"],
        named("quantity "),
        {key: float(each) for key, each in named("uncertainty ").items()},
        float(found["order"]),
        int(found["nodes"]),
    )
