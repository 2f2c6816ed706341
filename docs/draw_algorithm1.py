"""Draw docs/algorithm1.gif: Algorithm 1 brings particles to rest on the outline of the elements."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from PIL import Image

HERE = Path(__file__).resolve().parent
COMPACT = runpy.run_path(str(HERE.parent / "examples" / "compact.py"))
NUMBERS = COMPACT["NUMBERS"] | {"damping": 0.2}  # kg/s, below critical, so that the block swings
MAGNIFIED, EVERY, SHOWN = 150, 5, 40  # 1; steps a frame; frames before the one at rest
FRAME, END, COLOURS = 100, 2500, 16  # ms, of the last frame, 1
PARTICLES, ELEMENTS, SPRINGS = "#0072B2", "#D55E00", "0.7"  # blue and vermilion of Okabe and Ito


def main() -> None:
    """Write the picture beside this file."""
    n = NUMBERS["cells"]
    x0 = np.stack(np.indices((n + 1, n + 1)), axis=-1)
    springs = COMPACT["lattice"](n, NUMBERS["k2"], whole=False)
    steps = [x0 + MAGNIFIED * u for u in COMPACT["algorithm1"](**NUMBERS)]
    rest = x0 + MAGNIFIED * COMPACT["elements"](**NUMBERS)

    figure = Figure(figsize=(5.2, 4.8), dpi=80)
    canvas, axes = FigureCanvasAgg(figure), figure.add_axes((0.09, 0.1, 0.89, 0.82))
    axes.set(xlim=(-0.4, 6.6), ylim=(-0.4, 5.7), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.plot([0, n, n, 0, 0], [0, 0, n, n, 0], ":", color="0.4", label="unloaded")
    axes.plot(*rest[[0, -1, -1, 0, 0], [0, 0, -1, -1, 0]].T, color=ELEMENTS, label="elements")
    lines = axes.add_collection(LineCollection([], colors=SPRINGS, linewidths=0.8, zorder=1.5))
    (dots,) = axes.plot([], [], "o", color=PARTICLES, markersize=5, label="particles")
    axes.legend(loc="upper center", ncols=3, frameon=False, fontsize=9)

    frames = []
    for number in [*range(0, SHOWN * EVERY, EVERY), len(steps) - 1]:
        x, time = steps[number], number * NUMBERS["step"]
        ends = [np.stack([x[a], x[b]], axis=-2).reshape(-1, 2, 2) for a, b, _ in springs]
        lines.set_segments(np.concatenate(ends))
        dots.set_data(*x.reshape(-1, 2).T)
        axes.set_title(f"Step {number}, {time:.1f} s; displacements × {MAGNIFIED}", fontsize=11)
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    palette = frames[-1].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)  # of all frames
    first, *others = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    target, pauses = HERE / "algorithm1.gif", [FRAME] * len(others) + [END]
    first.save(target, save_all=True, append_images=others, duration=pauses, loop=0, optimize=True)
    sys.stdout.write(f"{target}: {target.stat().st_size / 1000:.0f} kB\n")


if __name__ == "__main__":
    main()
