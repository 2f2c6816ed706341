"""Case and result files changed at random, which end in a case, a result or one clear line.

python -m tests.msvalidate.case.file.mutated 100000
"""

from __future__ import annotations

import io
import random
import sys
import tempfile
from pathlib import Path

import numpy as np

from msvalidate.bench.output.vtu import vtu_bytes
from msvalidate.case.file.building import read_case
from msvalidate.case.judge.results import read_result
from msvalidate.problem import ProblemError

EXAMPLES = Path(__file__).parents[4] / "examples"
SEEDS = ("box.toml", "l_shape.toml", "ring.toml")
VALUES = (
    *("0", "-1", "nan", "inf", "1e400", "-0.0", "1e-320", "99999999999999999999", "true", '""',
        "[]"),
    *("[[]]", "{}", "[nan]", "1979-05-27", '"\\u0000"', '"../x"', "[1, 2, 3, 4]", '"left"', "0x7f"),
    *('"mm"', "[[0, 0], [0, 0], [0, 0]]", "[1e308, 1e308]", "[-1, 1]", '"<b>"', "'''a'''",
        "{x = 1}"),
)  # fmt: skip


def mutated_text(text: str, rng: random.Random) -> str:
    """A case file with some lines, values or letters changed."""
    lines = text.splitlines()
    for _ in range(rng.randint(1, 3)):
        place = rng.randrange(len(lines))
        way = rng.choice((0, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3, 4, 5, 6, 6, 6))
        if way == 0:
            del lines[place]
        elif way == 1:
            lines.insert(place, rng.choice(lines))
        elif way == 2 and "=" in lines[place]:
            lines[place] = lines[place].partition("=")[0] + "= " + rng.choice(VALUES)
        elif way == 3 and lines[place]:
            at = rng.randrange(len(lines[place]))
            letter = chr(rng.choice((0, 9, 34, 35, 39, 45, 46, 61, 91, 92, 93, 123, 233, 0x1F600)))
            lines[place] = lines[place][:at] + letter + lines[place][at + 1 :]
        elif way == 4:
            other = rng.randrange(len(lines))
            lines[place], lines[other] = lines[other], lines[place]
        elif way == 5:
            lines[place] = lines[place][: rng.randrange(len(lines[place]) + 1)]
        else:
            key = rng.choice(
                ("value", "components", "on", "at", "nodes", "point", "unit", "spacing")
            )
            lines.insert(place, f"{key} = {rng.choice(VALUES)}")
        if not lines:
            lines = [""]
    return "\n".join(lines)


def mutated_bytes(content: bytes, rng: random.Random) -> bytes:
    """A file with some bytes changed, left out or doubled."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 4)):
        if not data:
            break
        at = rng.randrange(len(data))
        way = rng.randrange(4)
        if way == 0:
            data[at] = rng.randrange(256)
        elif way == 1:
            del data[at : at + rng.randint(1, 20)]
        elif way == 2:
            data[at:at] = data[at : at + rng.randint(1, 20)]
        else:
            data = data[:at]
    return bytes(data)


def results() -> dict[str, bytes]:
    """Good result files: name -> content."""
    rng = np.random.default_rng(1)
    x, u = rng.uniform(0, 1, (5, 2)), rng.uniform(-1e-3, 1e-3, (5, 2))
    rows = "\n".join(",".join(f"{v:.9g}" for v in row) for row in np.c_[x, u])
    packed = io.BytesIO()
    np.savez(packed, points=x, displacement=u)
    cells = {"vertex": np.arange(5)[:, None]}
    return {
        "a.csv": f"x,y,ux,uy\n{rows}\n".encode(),
        "a.npz": packed.getvalue(),
        "a.vtu": vtu_bytes(x, cells, {"displacement": u}),
    }


def try_all(count: int, seed: int = 0) -> dict[str, int]:
    """Read so many changed files; how many ended how. Any other exception comes through."""
    rng = random.Random(seed)  # noqa: S311  no secret
    told = {"read": 0, "refused": 0, "in several lines": 0}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for mesh in EXAMPLES.glob("ring.msh"):
            (folder / mesh.name).write_bytes(mesh.read_bytes())
        texts = [(EXAMPLES / seed_file).read_text(encoding="utf-8") for seed_file in SEEDS]
        files = results()
        for number in range(count):
            try:
                if number % 3:
                    path = folder / "a.toml"
                    text = mutated_text(texts[rng.choice((0, 0, 0, 1, 1, 2))], rng)
                    path.write_text(text, encoding="utf-8", errors="surrogatepass")
                    read_case(path)
                else:
                    file = rng.choice(tuple(files))
                    path = folder / file
                    path.write_bytes(mutated_bytes(files[file], rng))
                    read_result(path, 2)
                told["read"] += 1
            except ProblemError as error:
                told["refused" if "\n" not in str(error) else "in several lines"] += 1
            except Exception as error:
                content = path.read_bytes()[:2000]
                raise AssertionError(f"{path.name}: {content!r}") from error
    return told


if __name__ == "__main__":
    print(try_all(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))  # noqa: T201
