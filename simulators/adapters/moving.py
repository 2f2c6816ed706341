# SPDX-License-Identifier: MIT
"""Programs that move a body step by step: a motion, and rest by kinetic damping from outside.

At rest the answer does not depend on how it came there, so no damping of the program is used: its
velocities are set to zero whenever its kinetic energy has passed a peak. A `body` here has ::

    place(x), halt()             positions (n, 3) m; all velocities to zero
    step()                       of the time that the program was given
    positions(), velocities()    (n, 3) m and m/s, copies
"""

from pathlib import Path

import numpy as np


def move(request, body, *, each_step=False, still=1e-7, floor=0.0, limit=100_000):
    """What is asked of a body, at its nodes' places before: (about, arrays) of an answer.

    Parameters
    ----------
    each_step
        "rest": halt after every step, for implicit programs, whose long steps are Newton's.
    still
        At rest when three halts in a row moved no point by more than this part of the largest
        displacement since the start,
    floor
        or by less than this (m): what positions in single precision resolve.
    limit
        Of steps to rest. What is reached then is given, with how much it still changes.
    """
    if request.task == "motion":
        body.place(request.start)
        body.halt()
        for _ in range(request.steps):
            body.step()
        arrays = {"position": body.positions(), "velocity": body.velocities()}
        return {"steps": request.steps, "at_rest": {}, "notes": ""}, arrays
    steps = _settle(body, each_step, (still, floor), limit)
    before = body.positions()
    energy = 0.0
    for _ in range(steps):
        energy = _damped(body, energy, each_step)
    now = body.positions()
    body.halt()
    body.step()  # how fast does what is left set off?
    known = {"largest_speed": float(abs(body.velocities()).max())}
    known["change_when_twice_as_long"] = float(abs(now - before).max())
    when = "each step" if each_step else "each peak of the kinetic energy"
    notes = f"velocities set to zero after {when}; largest_speed: a step after the last such halt"
    about = {"steps": 2 * steps, "at_rest": known, "notes": notes}
    return about, {"displacement": now - request.points}


def _settle(body, each_step, small, limit):
    """Steps taken until nothing moves."""
    begin = last = body.positions()
    energy, quiet, steps = 0.0, 0, 0
    while quiet < 3 and steps < limit:
        steps += 1
        energy = _damped(body, energy, each_step)
        if energy == 0.0:
            now = body.positions()
            bound = max(small[0] * abs(now - begin).max(), small[1])
            quiet = quiet + 1 if abs(now - last).max() <= bound else 0
            last = now
        elif not np.isfinite(energy):
            raise SystemExit(f"not at rest: diverged in step {steps}; take shorter steps")
    return steps


def _damped(body, energy, each_step):
    """Kinetic energy (of unit masses) after a step; 0 where its peak was passed and all halted."""
    body.step()
    now = float((body.velocities() ** 2).sum())
    if each_step or now < energy:
        body.halt()
        return 0.0
    return now


def stable_step(request, mass=None):
    """Half of what explicit steps of linear tetrahedra bear at most, s.

    The stiffness of an element is at most (lambda + 2 mu) volume times the squares of its shape
    functions' gradients summed, and a body vibrates no faster than its elements do alone.
    `mass` (n,) kg where it is not the request's.
    """
    m = request.material
    corners = request.points[request.cells]
    edges = corners[:, 1:] - corners[:, :1]
    gradients = np.linalg.inv(edges)
    square = (gradients**2).sum(axis=(1, 2)) + (gradients.sum(axis=2) ** 2).sum(axis=1)
    modulus = m.E * (1 - m.nu) / ((1 + m.nu) * (1 - 2 * m.nu))
    light = 1.0 if mass is None else float((mass / request.mass).min())
    return float(np.sqrt(light * m.density / (4 * modulus * square.max())))


def write_vtk(request, folder):
    """A file of the tetrahedra with all digits; its name."""
    cells = request.cells.tolist()
    lines = ["# vtk DataFile Version 3.0", "body", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(request.points)} double")
    lines += [" ".join(map(repr, x)) for x in request.points.tolist()]
    lines.append(f"CELLS {len(cells)} {5 * len(cells)}")
    lines += [" ".join(map(str, [4, *cell])) for cell in cells]
    lines += [f"CELL_TYPES {len(cells)}", *["10"] * len(cells)]
    path = Path(folder) / "body.vtk"
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return str(path)
