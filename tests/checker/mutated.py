"""Files of displacements changed at random, held to the checker's exit codes.

python -m tests.checker.mutated 3000
"""

from __future__ import annotations

import contextlib
import io
import random
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np

from msvalidate_check import elastic_case
from msvalidate_check.command import run
from tests.msvalidate.case.file.mutated import mutated_bytes

CASE = elastic_case("cell_pull_plane_strain")
NODES, U = CASE.points[CASE.named], CASE.wanted
ODD = (
    np.array(5.0), np.zeros((0, 2)), np.zeros((4, 2), bool), U.astype(complex), U.astype("U30"),
    U.astype(np.float16), U.astype(np.longdouble), U.T, U[None], np.full((4, 2), np.inf),
    U.astype([("a", float)]), np.arange(4), np.arange(4) - 9, np.full((4, 2), np.nan),
    np.array([b"x"]), np.zeros((4, 2)), np.array(-1.0), np.array(np.nan), 2**62 * np.ones(4, int),
    NODES - NODES.mean(axis=0), 0 * U + [0, 1e-3], 0 * U + [1e-3, 0],
)  # fmt: skip
TIMES = (*[1.0] * 12, 1e3, 1e-3, 0.0, -1.0, 1e250)


def archive(rng: random.Random) -> bytes:
    """An archive of arrays of which some are odd, then changed or not."""
    arrays = {"displacement": U, "points": NODES, "id": np.arange(4), "at_rest": np.array(0.01)}
    times = np.full(U.shape, rng.choice(TIMES))
    times[rng.randrange(4), rng.randrange(2)] = rng.choice(TIMES)
    arrays["displacement"] = times * U
    if rng.random() < 0.3:
        arrays[rng.choice(list(arrays))] = rng.choice(ODD)
    for name in rng.sample(list(arrays), rng.choice((0, 0, 1, 2))):
        del arrays[name]
    content = io.BytesIO()
    rng.choice((np.savez, np.savez_compressed))(content, **arrays)
    return mutated_bytes(content.getvalue(), rng) if rng.random() < 0.3 else content.getvalue()


def edited(rng: random.Random) -> bytes:
    """An archive that is whole, with the bytes of one array changed."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", rng.choice((0, 8, 12, 14))) as file:
        for name, values in (("displacement", U), ("points", NODES)):
            content = io.BytesIO()
            np.save(content, values)
            data = content.getvalue()
            if rng.random() < 0.5:
                data = mutated_bytes(data[:118], rng) + data[118:]
            file.writestr(f"{name}.npy", data)
    return packed.getvalue()


def table(rng: random.Random) -> bytes:
    """A table of numbers, changed."""
    numbers = np.c_[np.arange(4), NODES, rng.choice(TIMES) * U]
    rows = [",".join(f"{v:.9g}" for v in row) for row in numbers]
    return mutated_bytes("\n".join(["id,x,y,ux,uy", *rows, ""]).encode(), rng)


def try_all(count: int, seed: int = 0) -> Counter[int]:
    """Check so many changed files; how many ended with which exit code.

    A traceback comes through, and so does a message of no or of several lines.
    """
    rng = random.Random(seed)  # noqa: S311  no secret
    told: Counter[int] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            kind = (archive, archive, edited, table)[number % 4]
            path = Path(folder) / ("a.csv" if kind is table else "a.npz")
            path.write_bytes(kind(rng))
            out, err = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                code = run(["field", CASE.name, str(path)])
            said = err.getvalue()
            assert code in {0, 1, 2}, (seed, number, said)
            # A verdict is told in full, and nothing else; what is refused, in one line.
            verdict = out.getvalue().startswith(f"{CASE.name}, nu = 0.3: ")
            assert verdict == (code < 2) == (not said), (seed, number, said)
            assert said.count("\n") == (code == 2), (seed, number, said)
            told[code] += 1
    return told


if __name__ == "__main__":
    print(dict(try_all(int(sys.argv[1]))))  # noqa: T201
