"""What ``msvalidate advise`` takes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from msvalidate.cli.arguments import PROGRAM, Parser

CONSTANTS = ("k1", "k2", "k3")
EPILOG = f"""\
values may have units, else they are in SI: 6mm, 2.8GPa, 1.2g/cm3, 5kN/m

examples:
  {PROGRAM} advise --E 2.8GPa --nu .4 --thickness 6mm --spacing 2mm   a sheet
  {PROGRAM} advise --E 2e11 --nu .3 --spacing 1cm --engine springs    a solid, springs alone
  {PROGRAM} advise --identify --lattice square --k1 1e6 --k2 1e6 --spacing 2mm
  {PROGRAM} advise --identify reports/cases/my/springs.csv            points.csv beside it
"""


def parse_advise(words: Sequence[str]) -> argparse.Namespace:
    """The words after ``advise``; wrong usage ends the program with one line and exit code 2."""
    parser = Parser(
        prog=f"{PROGRAM} advise",
        description="Spring constants, masses and steps for a material, of every lattice that can.",
        epilog=EPILOG,
    )
    add = parser.add_argument
    add("--E", metavar="E", help="Young's modulus, 2.8GPa")
    add("--nu", metavar="NU", help="Poisson's ratio")
    add("--spacing", metavar="H", help="of the lattice, 2mm")
    add("--thickness", metavar="T", help="of a plane body, 6mm")
    add("--density", metavar="RHO", help="1000kg/m3 if none is given")
    states = ("plane_stress", "plane_strain", "solid")
    add("--state", choices=states, help="plane_stress with a thickness, else solid")
    add("--lattice", metavar="NAME", help="this one alone")
    add("--route", metavar="ROUTE", help="springs, or 'volume energy' (cells beside them)")
    said = "springs: an engine without cells, at the nearest ratio it has; cells: with them"
    add("--engine", choices=("springs", "cells"), help=said)
    add("--json", action="store_true", help="print JSON, in SI units")
    said = "which solid a network is: springs.csv with points.csv beside it, or --lattice"
    add("--identify", nargs="?", const="", metavar="FILE", help=said)
    add("--period", nargs="+", metavar="L", help="edges of a periodic sample: --period 2cm 2cm")
    for name in (*CONSTANTS, "kappa"):
        add(f"--{name}", metavar="K", help="of a lattice to identify")
    add("-v", "--verbose", action="store_true", help="tracebacks of crashes")
    args, rest = parser.parse_known_args(list(words))
    if rest:
        parser.error(f"unrecognized: {' '.join(rest)}; write a value and its unit as one, 6mm")
    used = {name for name in vars(args) if getattr(args, name) not in (None, False)}
    of_material = {"E", "nu", "route", "engine", "json", "state"}
    of_springs = {*CONSTANTS, "kappa", "period"}
    if args.identify is None:
        missing = [f"--{name}" for name in ("E", "nu", "spacing") if name not in used]
        if missing:
            parser.error(f"{missing[0]} is missing; give --E, --nu and --spacing")
    for name in sorted(used & (of_springs if args.identify is None else of_material)):
        where = "goes with" if args.identify is None else "does not go with"
        parser.error(f"--{name} {where} --identify; leave one of them out")
    args.jobs = 1
    return args
