"""Thickness against voltage, and how it comes to pull-in, drawn from the tables."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform

from .slab import HEIGHT, PULL_IN


def draw(tables: kit.Tables) -> Figure:
    """Thickness against voltage, and how it comes to pull-in."""
    figure, (whole, near) = kit.figures.new_figure(2, size=(3.4, 4.6))
    parts = np.linspace(0.45, 0.9999, 300)
    volts = np.array([uniform.voltage(part, height=HEIGHT) for part in parts])
    stable = parts >= PULL_IN.thickness
    whole.plot(volts[stable], parts[stable], color="black", lw=1.0, label="closed form")
    whole.plot(volts[~stable], parts[~stable], color="black", lw=1.0, ls="--", label="unstable")
    table, long = tables["between_walls"], tables["bonded"]
    _marked(whole, 0, table["voltage"], table["thickness"], "springs, between walls")
    _marked(whole, 1, table["voltage"], table["thickness_elements"], "elements, between plates")
    finest = long[(long["layers"] == long["layers"].max()) & (long["length_over_h"] < 10)]
    for place, (body, own) in enumerate(finest.groupby("body", sort=False), start=2):
        _marked(whole, place, own["voltage"], own["thickness"], f"bonded, {body}, middle")
    whole.plot(PULL_IN.voltage, PULL_IN.thickness, "k*", ms=11, label="pull-in")
    whole.set(xlabel="voltage (V)", ylabel="thickness over that at no voltage (1)")
    whole.set_title("thickness against voltage")
    missing = 1 - table["voltage_over_pull_in"]
    _marked(near, 0, missing, table["thickness"] - PULL_IN.thickness, "springs")
    _marked(near, 1, missing, table["thickness_elements"] - PULL_IN.thickness, "elements")
    left, above = 1 - volts[stable] / PULL_IN.voltage, parts[stable] - PULL_IN.thickness
    near.loglog(left, above, color="black", lw=1.0, label="closed form: a root")
    near.set(xlim=(5e-4, 1), ylim=(8e-3, 0.5))
    near.set_xlabel("voltage missing (1)")
    near.set_ylabel("thickness above pull-in's (1)")
    near.set_title("close to pull-in")
    below: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (-0.1, -0.2), "fontsize": 8}
    for axis in (whole, near):
        axis.legend(**below)
    figure.suptitle("A slab between electrodes, up to pull-in")
    return figure


def _marked(axis: Axes, place: int, x: pd.Series, y: pd.Series, label: str) -> None:
    larger: dict[str, Any] = {"mfc": "none", "ms": 8} if place == 1 else {}
    axis.plot(x, y.astype(float), ls="", label=label, **kit.figures.series_style(place), **larger)
