"""Extended position-based dynamics of springs on squares, with few iterations in a step."""

import numpy as np

from examples.spring_simulator import springs
from msvalidate.simulators.exchange.protocol import Answer


def batches(ends):
    """Numbers of springs in groups that share no node."""
    used, groups = {}, []
    for number, pair in enumerate(ends.tolist()):
        taken = used.setdefault(pair[0], set()) | used.setdefault(pair[1], set())
        group = next(i for i in range(len(taken) + 1) if i not in taken)
        groups += [[]] * (group == len(groups))
        groups[group] = [*groups[group], number]
        for node in pair:
            used[node].add(group)
    return groups


def simulate(request):
    """Positions from constraints: compliance over dt², so that few iterations are too soft."""
    X, material, own = request.mesh.points, request.material, request.settings
    ends, k = springs(request.mesh.cells, material.E, material.thickness)
    rest = request.task == "rest"
    free = ~request.held if rest else np.ones_like(request.held)
    dt = own.get("dt", 1 / 300) if rest else request.dt
    steps = own.get("steps", 120) if rest else request.steps
    iterations = own.get("iterations", 3)
    L0, w = np.linalg.norm(X[ends[:, 1]] - X[ends[:, 0]], axis=1), free / request.mass[:, None]
    groups = batches(ends)
    x, v = X + request.value if rest else request.start, np.zeros_like(X)
    for _ in range(steps):
        before = x
        v = v + dt * (w * request.force + free * request.gravity)
        x, tension = x + dt * v * (1 - 10 * dt * rest), np.zeros(len(k))
        for _ in range(iterations):
            for group in groups:
                (a, b), alpha = ends[group].T, 1 / k[group] / dt**2
                d = x[b] - x[a]
                L = np.linalg.norm(d, axis=1)
                n = d / L[:, None]
                weight = ((w[a] + w[b]) * n**2).sum(axis=1) + alpha
                change = -(L - L0[group] + alpha * tension[group]) / weight
                tension[group] += change
                x[a] -= w[a] * n * change[:, None]
                x[b] += w[b] * n * change[:, None]
        v = (x - before) / dt
    about = {
        "simulator": "positions",
        "version": "1",
        "law": "springs",
        "precision": "float64",
        "mass": "lumped",
        "forces_at": "end",
    }
    if not rest:
        return Answer(position=x, velocity=v, about=about)
    about["settings"] = {"dt": [dt, "s"], "steps": [steps, ""], "iterations": [iterations, ""]}
    about["at_rest"] = {"largest_speed": float(abs(v).max())}
    return Answer(displacement=x - X, about=about)
