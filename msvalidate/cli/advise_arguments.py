"""What ``msvalidate advise`` takes."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping, Sequence

from msvalidate.case.units import DENSITY, LENGTH, PRESSURE, STIFFNESS
from msvalidate.cli.arguments import PROGRAM, Parser

CONSTANTS = ("k1", "k2", "k3")
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S*)\s*")
EPILOG = f"""\
values may have units, else they are in SI: 6mm, 2.8GPa, 1.2g/cm3, 5kN/m

examples:
  {PROGRAM} advise --E 2.8GPa --nu .4 --thickness 6mm --spacing 2mm   a sheet
  {PROGRAM} advise --E 2e11 --nu .3 --spacing 1cm --engine springs    a solid, springs alone
  {PROGRAM} advise --identify --lattice square --k1 1e6 --k2 1e6 --spacing 2mm
  {PROGRAM} advise --identify reports/cases/my/springs.csv            points.csv beside it
"""


def in_si(units: Mapping[str, float]) -> Callable[[str], float]:
    """What reads a number with one of some units as one in SI units."""

    def read(given: str) -> float:
        match = NUMBER.fullmatch(given)
        if not match or match[2] not in {"", *units}:
            unit = f", or one with {', '.join(units)}" if units else ""
            raise argparse.ArgumentTypeError(f"{given!r}; give a number in SI units{unit}")
        return float(match[1]) * units.get(match[2], 1.0)

    return read


def parse_advise(words: Sequence[str]) -> argparse.Namespace:
    """The words after ``advise``; wrong usage ends the program with one line and exit code 2."""
    parser = Parser(
        prog=f"{PROGRAM} advise",
        description="Spring constants, masses and steps for a material, of every lattice that can.",
        epilog=EPILOG,
    )
    parser._negative_number_matcher = re.compile(r"-\.?\d")  # -.5e3, -1kPa are values
    add, length = parser.add_argument, in_si(LENGTH)
    add("--E", metavar="E", type=in_si(PRESSURE), help="Young's modulus, 2.8GPa")
    add("--nu", metavar="NU", type=in_si({}), help="Poisson's ratio")
    add("--spacing", metavar="H", type=length, help="of the lattice, 2mm")
    add("--thickness", metavar="T", type=length, help="of a plane body, 6mm")
    add("--density", metavar="RHO", type=in_si(DENSITY), help="1000kg/m3 if none is given")
    states = ("plane_stress", "plane_strain", "solid")
    add("--state", choices=states, help="plane_stress with a thickness, else solid")
    add("--lattice", metavar="NAME", help="this one alone")
    add("--route", metavar="ROUTE", help="springs, or 'volume energy' (cells beside them)")
    said = "springs: an engine without cells, at the nearest ratio it has; cells: with them"
    add("--engine", choices=("springs", "cells"), help=said)
    add("--json", action="store_true", default=None, help="print JSON, in SI units")
    said = "which solid a network is: springs.csv (points.csv, cells.csv beside it), or --lattice"
    add("--identify", nargs="?", const="", metavar="FILE", help=said)
    said = "edges of a periodic sample: --period 2cm 2cm"
    add("--period", nargs="+", metavar="L", type=length, help=said)
    for name in CONSTANTS:
        add(f"--{name}", metavar="K", type=in_si(STIFFNESS), help="of a lattice to identify")
    said = "of its cells: N/m in the plane, Pa in space"
    add("--kappa", metavar="K", type=lambda k: (in_si(STIFFNESS | PRESSURE)(k), k), help=said)
    add("-v", "--verbose", action="store_true", help="tracebacks of crashes")
    args, rest = parser.parse_known_args(list(words))
    if rest:
        parser.error(f"unrecognized: {' '.join(rest)}; write a value and its unit as one, 6mm")
    advises = args.identify is None
    given = {name for name, value in vars(args).items() if value is not None}
    for name in ("E", "nu", "spacing"):
        if advises and name not in given:
            parser.error(f"--{name} is missing; give --E, --nu and --spacing")
    of_material, of_springs = "E nu route engine json state", "k1 k2 k3 kappa period"
    for name in sorted(given & set((of_springs if advises else of_material).split())):
        where = "goes with" if advises else "does not go with"
        parser.error(f"--{name} {where} --identify; leave one of them out")
    for name in ("lattice", "spacing", "density", *CONSTANTS, "kappa") if args.identify else ():
        if name in given:
            parser.error(f"--{name} is of a lattice, and {args.identify!r} a file; leave it out")
    own = [name in given for name in CONSTANTS]
    if own != sorted(own, reverse=True):
        parser.error(f"--{CONSTANTS[own.index(False)]} is missing; give the kinds before it too")
    args.jobs = 1
    return args
