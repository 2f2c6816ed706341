"""What explains a field, as records: decisions look at kinds, and sentences are made of them last.

A `Cause` is of a kind, with the number that it fits. What its sentence names is a `Phrase`: a key
of a table of templates and values to put there, which may be phrases themselves. No decision looks
at a template or at what `say` makes of it; `PHRASES` has all the templates of the checker.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

PHRASES = {
    "and": " and ",
    "zero": "nothing moves: the displacements are all 0",
    "rest": "not at rest: it may still change by as much",
    # Scales.
    "unit besides": "{unit}, and {times:.4g} times as large besides",
    "unit": "{scale:.4g} times elasticity: {unit}?",
    "modulus": "{scale:.4g} times elasticity: a modulus E {part:.4g} times as large?",
    "of stiffness": "spring constants or a modulus {part:.4g} times as large, from a confusion of "
    "{units}",
    "loads": "{scale:.4g} times elasticity: loads {scale:.4g} times as large?",
    "weight": "{scale:.4g} times elasticity: gravity or masses {scale:.4g} times as large?",
    "thickness": "{scale:.4g} times elasticity: a thickness {part:.4g} times as large?",
    "supports": "{scale:.4g} times elasticity: prescribed displacements {scale:.4g} times as large?"
    " (No modulus shows where supports alone move the body.)",
    "scale": "{scale:.4g} times elasticity",
    "scale and": "{scale:.4g} times {image}: modulus or loads besides?",
    "unit and": "{scale:.4g} times {image}: {unit}?",
    # Known mistakes, solved on the body.
    "coarse mesh": "linear elements of about {length}: take a finer mesh, or quadratic elements",
    "coarse springs": "the right springs at a spacing of about {length}: take a smaller one",
    "whole boundary springs": "springs on the boundary count whole: give those in a side half their"
    " constant, in an edge of a solid a quarter",
    "and whole boundary springs": "springs on the boundary count whole",
    "and unit of k": "and {unit}",
    "and k without h": "and constants without their factor h: multiply each by the spacing in m",
    "and scale": "and a modulus {part:.4g} or loads {scale:.4g} times as large besides",
    "k2 = 2 k1": "k2 = 2 k1, k1 {value:.4g} times the right one: each kind of spring has its own "
    "constant",
    "k alike": "the same k on every spring, {value:.4g} times E·h (in 2D E·t): take the constants "
    "that `advise` reports",
    "k = E h": "k = E·h (in 2D E·t) on every spring: take the constants that `advise` reports",
    "k = E": "k = E, a number of Pa taken as N/m, on every spring: take the constants that "
    "`advise` reports",
    "axes alone": "springs along the axes alone, {value:.4g} times E·h (in 2D E·t): no diagonals "
    "resist shear",
    "equal masses": "equal masses at all points: give each the share of the cells around it",
    "doubled mass": "masses twice as large: do cells and springs both bring them?",
    "load sign": "load {value:.0f} of the case acts in the opposite direction: reverse its sign",
    "load missing": "load {value:.0f} of the case does not act: apply it",
    "weight missing": "the weight does not act: apply gravity",
    "weight sign": "the weight acts in the opposite direction: reverse the sign of gravity",
    "thickness beside weight": "forces {value:.4g} times as large, the weight not: another "
    "thickness?",
    "rest length": "rest lengths differ from the springs' lengths by {value:+.2g} of these",
    "not converged": "not converged: {value:.2g} of the displacement is missing; take more "
    "iterations or steps",
    "mistake and": "{one}; {other}",
    # Images of elasticity, and components.
    "elasticity": "elasticity",
    "component": "elasticity with no displacement along {axis}: is that component written",
    "plane state": "elasticity in {state} (the same here as E {E:.4g} times as large, "
    "nu = {nu:.4g})",
    "mirrored": "elasticity of the body mirrored along {axes}",
    "places": "elasticity at places mirrored along {axes}",
    "named": "{name}",
    "image": "{image}?",
    "as image": "as {image} give it: take a finer mesh",
    "axes": "components in the order {order}",
    "sign": "the other sign",
    "signs": "the other sign of {axes}",
    "with": "{image} with {frame}",
    # Ratios.
    "ratio": "Poisson's ratio {nu:.4g} in place of {given:g}?",
    "of ratio": "elasticity of Poisson's ratio {nu:.4g} (given {given:g})",
    "times of ratio": "{scale:.4g} times {image}?",
    "coarse mesh and ratio": "as {image} give it for Poisson's ratio {nu:.4g} (given {given:g})?",
    # Places, points, motions, order.
    "positions": "positions in place of displacements: take the places at rest off",
    "positions in unit": "positions in place of displacements, in {unit}?",
    "positions and scale": "positions in place of displacements, and displacements {scale:.4g} "
    "times elasticity",
    "positions and unit": "positions in place of displacements, and displacements {scale:.4g} "
    "times elasticity: {unit}?",
    "one point": "one point wrong, the first at ({place}) {unit}",
    "points": "{count} points wrong, the first at ({place}) {unit}",
    "right": "{points}; all others are right to {left:.1g} of the largest",
    "right as known": "{points}; all others are right to what is known",
    "others scaled": "{points}; all others {scale:.4g} times elasticity",
    "others coarse": "{points}; all others as {image} give them",
    "rigid motion": "elasticity and a rigid motion: other supports, or another frame?",
    "reversed": "elasticity of the nodes in the reverse order?",
    "reversed in unit": "elasticity of the nodes in the reverse order, in {unit}?",
    "other nodes": "elasticity of other nodes, each of one: is their order lost?",
    "other nodes in unit": "elasticity of other nodes, each of one, in {unit}: is their order "
    "lost?",
}
"""Key of a phrase -> template."""


@dataclass(frozen=True)
class Phrase:
    """A key of a table of templates, and the values (name, value) that the template names."""

    key: str
    values: tuple[tuple[str, Any], ...] = ()

    def __getitem__(self, name: str) -> Any:
        return dict(self.values)[name]


def phrase(key: str, /, **values: object) -> Phrase:
    """A phrase with its values: numbers, texts, phrases, or tuples of these."""
    return Phrase(key, tuple(values.items()))


@dataclass(frozen=True)
class Cause:
    """Why something differs.

    Parameters
    ----------
    kind
        Of the cause, a short name, for tables.
    value
        The number that it fits: a scale, a ratio, a count; NaN if none.
    of
        What its sentence names.
    left
        Largest difference that it leaves, over elasticity's largest displacement, with the field
        brought to elasticity's size; NaN where nothing was fitted.
    beside
        Kind of a second one at once; "" if there is none.
    """

    kind: str
    value: float = math.nan
    of: Phrase = field(default_factory=lambda: Phrase(""))
    left: float = math.nan
    beside: str = ""

    def __str__(self) -> str:
        return self.said

    @property
    def kinds(self) -> frozenset[str]:
        """Its kind, or both of two at once."""
        return frozenset({self.kind, self.beside} - {""})

    @property
    def name(self) -> str:
        """Its kind, for tables; both of two at once, joined by "and"."""
        return " and ".join(filter(None, (self.kind, self.beside)))

    @property
    def said(self) -> str:
        """As a sentence."""
        return say(self.of, PHRASES)

    def row(self) -> dict[str, Any]:
        """As a row of a table."""
        return {"name": self.name, "said": self.said, "left": self.left, "value": self.value}


def say(of: object, templates: Mapping[str, str]) -> str:
    """A phrase as text, by a table of templates, whose "and" joins tuples; others as they are."""
    if isinstance(of, tuple):
        return templates["and"].join(say(each, templates) for each in of)
    if not isinstance(of, Phrase):
        return str(of)
    values = {name: _value(each, templates) for name, each in of.values}
    return templates[of.key].format(**values)


def _value(given: object, templates: Mapping[str, str]) -> object:
    """What a template formats: numbers as they are, phrases and tuples as text."""
    return say(given, templates) if isinstance(given, Phrase | tuple) else given
