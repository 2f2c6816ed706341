"""Voltages that hold a thickness, and fields that let a wave grow, drawn from the tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform

from . import slab


def draw(tables: kit.Tables) -> Figure:
    """Voltages that hold a thickness, and fields that let a wave grow."""
    figure, (thin, wave) = kit.figures.new_figure(2, size=(3.4, 4.4))
    parts = np.linspace(0.35, 0.9999, 200)
    net = [uniform.voltage(part) / slab.HEIGHT / slab.NATURAL for part in parts]
    wide = parts**-0.5
    curves = {
        "lattice, area held": net,
        "stress linear, area held, √(C/ε)": list(np.sqrt(2 * parts**2 * (1 - parts))),
        "neo-Hookean, free": [uniform.biaxial_nominal_field(w) for w in wide],
        "neo-Hookean, plane strain": [uniform.plane_strain_nominal_field(w**2) for w in wide],
    }
    for place, (label, nominal) in enumerate(curves.items()):
        thin.plot(parts, nominal, color=kit.figures.COLOURS[place], label=label)
    known = tables["which"]
    found = known[[isinstance(value, float) for value in known["thickness_found"]]]
    thickness, field = (found[f"{name}_found"].astype(float) for name in ("thickness", "nominal"))
    thin.plot(thickness, field, kit.figures.MARKERS[0], color="black", label="pull-in, computed")
    thin.set_xlabel("thickness over that at no voltage (1)")
    thin.set_ylabel("nominal field over its unit, √(μ/ε) (1)")
    waves, kappa = tables["waves_of_a_film"], np.geomspace(0.4, 20.0, 200)
    exact, style = [uniform.bonded_film_field(k) for k in kappa], kit.figures.series_style(0)
    wave.semilogx(kappa, exact, color=style["color"], label="bonded film, linear, volume kept")
    wave.semilogx(
        waves["kh"], waves["field_found"], ls="", label="its stiffness by elements", **style
    )
    known_fields = (
        ("√2, short waves", "-", uniform.bonded_film_limit()),
        ("creases, theory", "--", uniform.CREASING_FIELD_THEORY),
        ("creases, experiment", ":", uniform.CREASING_FIELD_EXPERIMENT),
    )
    for name, line, value in known_fields:
        wave.axhline(value, ls=line, color="#444444", lw=1.0, label=name)
    creased = 2 * np.pi / uniform.CREASING_WAVELENGTH
    wave.axvline(creased, ymax=0.6, color="#bbbbbb", lw=1.0)
    words: dict[str, Any] = {"rotation": 90, "ha": "right", "va": "center"}
    wave.text(0.95 * creased, 2.2, "creases' distance", fontsize=7.5, color="#666666", **words)
    wave.set(xlabel="wavenumber times height, kh (1)", ylim=(0.5, 4.3))
    wave.set_ylabel("true field over √(μ/ε) (1)")
    thin.set_title("uniform: fields that hold a thickness")
    wave.set_title("waves: fields that let them grow")
    below: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (-0.1, -0.2), "fontsize": 8}
    for axis in (thin, wave):
        axis.legend(**below)
    figure.suptitle("Pull-in and creases: which field is meant")
    return figure
