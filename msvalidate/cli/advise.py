"""What ``msvalidate advise`` does: springs for a material, or the solid that springs are."""

from __future__ import annotations

import argparse
import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path

from msvalidate import case
from msvalidate.case.advice import Advice, advice_lines, advice_record, advise
from msvalidate.case.identify import habits, identified_lines, identify_lattice
from msvalidate.case.places import UNITS
from msvalidate.cli.advise_arguments import CONSTANTS
from msvalidate.cli.terminal import print_lines
from msvalidate.constants.stiffness import ALIKE, axes_moduli, lame
from msvalidate.lattice.patterns import all_patterns
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.checks import require_one_of
from msvalidate.problem.material import State

PRESSURE = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
DENSITY = {"kg/m3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3}
STIFFNESS = {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3}
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S*)\s*")


def act(args: argparse.Namespace) -> int:
    """Do what the command line asks for; return the exit code."""
    return _advise(args) if args.identify is None else _identify(args)


def _value(
    args: argparse.Namespace, name: str, units: Mapping[str, float], default: float = 0.0
) -> float:
    """An option's number in SI units."""
    given = getattr(args, name)
    return default if given is None else _number(f"--{name}", given, units)


def _number(name: str, given: str, units: Mapping[str, float]) -> float:
    match = NUMBER.fullmatch(given)
    if not match or match[2] not in {"", *units}:
        unit = f", or one with {', '.join(units)}" if units else ""
        raise ProblemError(f"{name}: {given!r}; give a number in SI units{unit}")
    return float(match[1]) * units.get(match[2], 1.0)


def _material(args: argparse.Namespace) -> tuple[Isotropic, str]:
    """The material, and what was taken for what is not given."""
    state: State = args.state or ("plane_stress" if args.thickness else "solid")
    if state == "solid" and args.thickness:
        raise ProblemError("--thickness: a solid has none; leave it out, or take a plane --state")
    m = Isotropic(
        E=_value(args, "E", PRESSURE),
        nu=_value(args, "nu", {}),
        state=state,
        density=_value(args, "density", DENSITY, 1000.0),
        thickness=_value(args, "thickness", UNITS, 1.0),
    )
    thick = f", {m.thickness:g} m thick" if m.dim == 2 else ""
    taken = "" if args.state else " (taken; another by --state)"
    density = f"{m.density:g} kg/m³{'' if args.density else ' (taken; another by --density)'}"
    return m, f"E = {m.E:g} Pa, nu = {m.nu:g} in {state}{taken}{thick}, {density}"


def _advise(args: argparse.Namespace) -> int:
    """Springs of every lattice that can, and why others can't."""
    material, head = _material(args)
    spacing = _value(args, "spacing", UNITS)
    route = "springs" if args.engine == "springs" else args.route
    if args.route not in (None, route):
        raise ProblemError("--route: an engine of springs has no cells; leave one of them out")
    materials, price = _materials(args.engine, material)
    known = [name for name, make in all_patterns().items() if make().dim == material.dim]
    found: list[Advice] = []
    cannot: dict[str, str] = {}
    for name in [args.lattice] if args.lattice else known:
        for each in materials:
            try:
                found.append(advise(each, name, spacing, route))
                break
            except ProblemError as error:
                cannot.setdefault(name, str(error))
    if not found:
        raise ProblemError(next(iter(cannot.values())))
    for advice in found:
        cannot.pop(advice.lattice, None)
    if args.json:
        records = [advice_record(advice) for advice in found]
        record = {"lattices": records, "cannot": cannot, "springs_alone": price}
        return print_lines([json.dumps(record, ensure_ascii=False, indent=1)])
    lines = [head, *([price] if price else []), _letters(found[0].material)]
    lines += [line for advice in found for line in advice_lines(advice)]
    lines += [f"not {name}: {why.split(' lattice: ')[-1]}" for name, why in cannot.items()]
    if not args.lattice:
        lines += ["what people do:", *(f"  {line}" for line in habits(material.dim))]
    return print_lines([*lines, *_engines(args.engine, found[0])])


def _materials(engine: str | None, material: Isotropic) -> tuple[list[Isotropic], str]:
    """The material, and if springs alone are asked for the nearest they can be, and its price."""
    if engine != "springs":
        return [material], ""
    from msvalidate.case.nearest_ratio import nearest_by_springs, price_of_ratio

    nearest = nearest_by_springs(material)
    if abs(nearest.nu - material.nu) <= ALIKE:
        return [material], ""
    low, high = (100 * part for part in price_of_ratio(material, nearest))
    but = " (honeycomb: others too)" if material.dim == 2 else ""
    return [material, nearest], (
        f"springs alone have nu = {nearest.nu:.4g}{but}: displacements of clamped blocks change by "
        f"{low:.2g} to {high:.2g} % (pulled, sheared, bent or pressed, of the same E; by elements)"
    )


def _letters(m: Isotropic) -> str:
    """What the formulas' letters are."""
    E, nu = axes_moduli(m, m.dim, "advise")
    second, mu = lame(m.dim, E / m.thickness, nu)
    said = "λ′ = Eν/(1 - ν²)" if m.state == "plane_stress" else "λ = Eν/((1 + ν)(1 - 2ν))"
    cells = "½κ(ΔA)²/A, A a cell's area" if m.dim == 2 else "½κ(ΔV)²/V, V a cell's volume"
    return (
        f"at nu = {m.nu:.6g}: μ = E/(2(1 + ν)) = {mu:.6g} Pa, {said} = {second:.6g} Pa; "
        f"t thickness, h spacing; energy by κ {cells}"
    )


def _engines(engine: str | None, advice: Advice) -> list[str]:
    """How other programs take the numbers of a lattice."""
    table, m = Path(case.__file__).with_name("engines.toml"), advice.material
    if engine is None or not table.exists():
        return ["how other programs take these: --engine springs, --engine cells"]
    names = {"mu": lame(3, m.E, m.nu)[1], "lam": lame(3, m.E, m.nu)[0], "E": m.E}
    names |= {"rho": m.density, "t": m.thickness}
    each = [names | {"k": kind.constant, "L": kind.length} for kind in advice.kinds]
    lines = (
        [f"how other programs take {advice.lattice}'s:"]
        if engine == "springs"
        else ["how programs of elements take the material:"]
    )
    for row in tomllib.loads(table.read_text(encoding="utf-8"))["engine"]:
        if (row["takes"] == "elements") == (engine == "cells"):
            values = dict.fromkeys(f"{_product(row['factor'], known):.6g}" for known in each)
            number = f"{row['factor']} = {', '.join(values)} {row['unit']}; " * bool(row["factor"])
            lines.append(f"  {row['name']}: {number}{row['note']} {row['source']}")
    return lines


def _product(factor: str, known: Mapping[str, float]) -> float:
    """Value of a product of names and numbers, such as "k*L" or "E/rho"."""
    value = 1.0
    for sign, word in re.findall(r"([*/]?)(\w+)", factor):
        part = known[word] if word in known else float(word)
        value *= 1 / part if sign == "/" else part
    return value


def _identify(args: argparse.Namespace) -> int:
    """Which solid springs are."""
    thickness = _value(args, "thickness", UNITS) if args.thickness else None
    if args.identify:
        from msvalidate.case.identify_files import identify_files

        period = tuple(_number("--period", length, UNITS) for length in args.period or ())
        found = identify_files(Path(args.identify), period or None)
        return print_lines(identified_lines(found, thickness))
    if not (args.lattice and args.spacing):
        raise ProblemError("--identify: give a springs.csv, or --lattice, --k1 .. and --spacing")
    require_one_of("--lattice", args.lattice, all_patterns())
    plane = all_patterns()[args.lattice]().dim == 2
    if plane and args.density and thickness is None:
        raise ProblemError("--density: a plane lattice's mass takes its --thickness too; give both")
    found = identify_lattice(
        args.lattice,
        tuple(_value(args, name, STIFFNESS) for name in CONSTANTS if getattr(args, name)),
        _value(args, "spacing", UNITS),
        _value(args, "kappa", STIFFNESS if plane else PRESSURE),
        _value(args, "density", DENSITY) * (thickness or 1.0) if args.density else None,
    )
    return print_lines(identified_lines(found, thickness))
