"""Animations of networks as GIF images."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from msvalidate.bench.output.body_drawing import (
    AT_REST,
    Drawing,
    body_axes,
    common_magnification,
    draw_springs,
    draw_supports,
    network_drawing,
)
from msvalidate.bench.output.figures import COLOURS, figure_style
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import format_value, positive_number, require_type
from msvalidate.problem.records import dataclass
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.dynamics.run import MAX_FRAME_POINTS, Relaxation
from msvalidate.springs.network import Network
from msvalidate_check import exchange

MAX_SHOWN = 60
"""Maximum number of frames of an animation.

They take a few seconds, and a file of about 1 MB.
"""
FRAME_MILLISECONDS, LAST_MILLISECONDS = 80, 1500
DOTS_PER_INCH = 80


@dataclass(frozen=True)
class Animation:
    """Animation that a notebook shows and that `save` writes.

    Parameters
    ----------
    gif
        Content of the GIF file.
    title
        Sentence for readers who do not see it.
    """

    gif: bytes
    title: str

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.gif).decode("ascii")
        return f'<img alt="{self.title}" src="data:image/gif;base64,{data}">'

    def save(self, path: str | Path) -> Path:
        """Write a GIF image or an HTML page, by the suffix of the path."""
        place = Path(path)
        if place.suffix not in (".gif", ".html"):
            raise ProblemError(f"animation: {format_value(str(path))}; give a .gif or .html file")
        html = f"<!doctype html><title>{self.title}</title>{self._repr_html_()}"
        content = self.gif if place.suffix == ".gif" else html.encode()
        exchange.write(place.parent, {place.name: content})
        return place


def animate(
    result: Relaxation | Network,
    states: Sequence[Array | State] = (),
    magnification: float | None = None,
) -> Animation:
    """Animate a relaxation, or the states of a motion.

    Parameters
    ----------
    result
        Result of `relax`, or the network of the states.
    states
        States, such as a function ``watch`` receives from `motion`, or displacements (m) of shape
        (n, d). At most 60 of them are drawn.
    magnification
        Factor of the displacements, > 0. Default: as for `plot`, for the largest.

    Returns
    -------
    Animation
        GIF image, shown in a notebook; its ``save`` writes a .gif or .html file.

    Raises
    ------
    ProblemError
        If there is no state to show, or a displacement or the magnification is invalid.

    Examples
    --------
    >>> import msvalidate as ms
    >>> problem = ms.body(
    ...     ms.Box(0.4, 0.1), ms.Isotropic(E=1e5, nu=1 / 3), fixed="left", gravity=(0, -9.81)
    ... )
    >>> result = ms.relax(ms.build(problem, cells=1), "algorithm1")
    >>> animation = ms.animate(result)  # animation.save("algorithm1.gif") writes a file
    >>> animation.gif[:6]
    b'GIF89a'
    """
    if isinstance(result, Relaxation):
        network, frames = result.network, {f"step {n}": u for n, u in result.frames.items()}
    else:
        require_type("animate", result, Network)
        network, frames = result, {}
        for number, state in enumerate(states):
            moved = state.position - result.points if isinstance(state, State) else state
            frames[f"state {number + 1} of {len(states)}"] = moved
    if not frames:
        raise ProblemError(
            "animate: no states; give a relaxation of at most "
            f"{MAX_FRAME_POINTS:,} points, or a network and its states: animate(network, states)"
        )
    drawings = {title: network_drawing(network, u) for title, u in frames.items()}
    picked = np.unique(np.linspace(0, len(frames) - 1, MAX_SHOWN).round().astype(int))
    shown = [list(drawings.items())[i] for i in picked]
    times = common_magnification([each for _, each in shown])
    times = positive_number("magnification", times if magnification is None else magnification)
    images = _render(shown, times)
    content = io.BytesIO()
    pauses = [FRAME_MILLISECONDS] * (len(images) - 1) + [LAST_MILLISECONDS]
    options = {"save_all": True, "append_images": images[1:], "duration": pauses, "loop": 0}
    images[0].save(content, "GIF", **options)
    title = f"Motion of a network of {len(network.springs):,} springs, magnified {times:g} times"
    return Animation(content.getvalue(), title)


def _render(shown: list[tuple[str, Drawing]], magnification: float) -> list[Image.Image]:
    """Return an image per drawing, all on the same axes."""
    _, first = shown[0]
    moved = [each.points + magnification * each.displacement for _, each in shown]  # type: ignore[operator]
    images = []
    with figure_style():
        figure, axis = body_axes(np.concatenate([first.points, *moved]), 0.05 * first.size)
        canvas: Any = FigureCanvasAgg(figure)
        figure.set_dpi(DOTS_PER_INCH)
        draw_springs(axis, first.points, first.lines, "undeformed", AT_REST)
        lines = draw_springs(axis, moved[0], first.lines, "springs", COLOURS[0])
        if first.points.shape[1] == 2:
            draw_supports(axis, first.points, first.fixed, 4.0)
        for (title, _), at in zip(shown, moved, strict=True):
            lines.set_segments(at[first.lines])
            axis.set_title(f"{title}, displacements magnified {magnification:g} times", loc="left")
            canvas.draw()
            figure.set_layout_engine("none")  # the axes stay where the first frame has them
            image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
            images.append(image.quantize(32))
    return images
