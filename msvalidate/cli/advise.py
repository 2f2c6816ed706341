"""Command ``msvalidate advise``: springs for a material, or the solid of given springs."""

from __future__ import annotations

import argparse
import json
import textwrap
import tomllib
from pathlib import Path

from msvalidate.case import advise as advise_package
from msvalidate.case.advise.advice import (
    Advice,
    advice_lines,
    advice_record,
    advise,
    constants_lines,
    step_sentence,
)
from msvalidate.case.advise.identify import (
    identified_lines,
    identify_cubic,
    identify_lattice,
    mass_density,
)
from msvalidate.case.judge.mistakes import mistake_lines
from msvalidate.cli.arguments import CONSTANTS
from msvalidate.cli.terminal import print_lines
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.checks import positive_number, require_one_of
from msvalidate.problem.material import State
from msvalidate.problem.records import replace
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    UNIT,
    axes_moduli,
    lame,
    springs_ratio,
    young_and_ratio,
)
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate_check.text import WIDTH, align_table


def print_advice(args: argparse.Namespace) -> int:
    """Print springs for a material, or the solid that springs are."""
    return print_lines(_advise(args) if args.identify is None else _identify(args))


def _material(args: argparse.Namespace) -> tuple[Isotropic, str]:
    """Material, and the line that describes it, with the defaults that were taken."""
    t = args.thickness
    state: State = args.state or ("solid" if t is None else "plane_stress")
    if state == "solid" and t is not None:
        raise ProblemError("--thickness: a solid has none; leave it out, or take a plane --state")
    density = Isotropic.density if args.density is None else args.density
    E, nu = args.E, args.nu
    if args.mu is not None:
        mu = positive_number("--mu", args.mu, "Pa")
        K = args.lame + 2 * mu / 3 if args.K is None else args.K
        E, nu = young_and_ratio(3, positive_number("bulk modulus K = λ + 2μ/3", K, "Pa"), mu)
    m = Isotropic(E, nu, state, density, 1.0 if t is None else t)
    auxetic = ", auxetic: it widens when it is pulled" if m.nu < 0 else ""
    thick = f", {m.thickness:g} m thick" if m.dim == 2 else ""
    default = "" if args.state else " (default; another by --state)"
    return (
        m,
        f"E = {m.E:g} Pa, nu = {m.nu:g}{auxetic}, {state}{default}{thick}",
    )


def _advise(args: argparse.Namespace) -> list[str]:
    """Springs of every lattice that can, and why others can't."""
    material, head = _material(args)
    route = "springs" if args.engine == "springs" else None
    materials, price = _materials(args.engine, material)
    known = [name for name, make in all_patterns().items() if make().dim == material.dim]
    found: list[Advice] = []
    cannot: dict[str, str] = {}
    for name in [args.lattice] if args.lattice else known:
        for each in materials:
            try:
                found.append(advise(each, name, args.spacing, route))
            except ProblemError as error:
                cannot.setdefault(name, str(error))
            else:
                cannot.pop(name, None)
                break
    if not found:
        raise ProblemError(next(iter(cannot.values())))
    if args.json:
        records = [advice_record(advice) for advice in found]
        record = {"lattices": records, "cannot": cannot, "springs_alone": price}
        return [json.dumps(record, ensure_ascii=False, indent=1)]
    summary = [head, *([price] if price else []), _letters(found[0].material)]
    summary += constants_lines(found, density=" (default)" * (args.density is None))
    summary.append(step_sentence(found, args.step))
    summary += [f"not for this material: {', '.join(cannot)}"] * bool(cannot)
    summary += _engines(args.engine, found[0], args.step, notes=args.verbose)
    if not args.verbose:
        return [line for text in summary for line in textwrap.wrap(text, WIDTH) or [text]]
    lines = [*summary, *(line for advice in found for line in advice_lines(advice))]
    lines += [f"not {name}: {why.split(' lattice: ')[-1]}" for name, why in cannot.items()]
    if not args.lattice:
        plain = {2: "square", 3: "cubic18"}[material.dim]
        known = mistake_lines(material, plain, args.spacing)
        lines += ["known mistakes:", *(f"  {line}" for line in known)]
    return lines


def _materials(engine: str | None, material: Isotropic) -> tuple[list[Isotropic], str]:
    """The material, and if springs alone are asked for the nearest they can be, and its price."""
    if engine != "springs":
        return [material], ""
    from msvalidate.case.advise.nearest_ratio import change_of_blocks

    nu = springs_ratio(material)
    if abs(nu - material.nu) <= ALIKE:
        return [material], ""
    low, high = (100 * part for part in change_of_blocks(material, nu))
    but = " (honeycomb: others too)" if material.dim == 2 else ""
    return [material, replace(material, nu=nu)], (
        f"springs alone have nu = {nu:.4g}{but}: displacements of clamped blocks change by "
        f"{low:.2g} to {high:.2g} % (pulled, sheared, bent or pressed, of the same E; by elements)"
    )


def _letters(m: Isotropic) -> str:
    """Describe the meaning of the letters in the formulas."""
    E, nu = axes_moduli(m, m.dim, "advise")
    second, mu = lame(m.dim, E / m.thickness, nu)
    said = "λ′ = Eν/(1 - ν²)" if m.state == "plane_stress" else "λ = Eν/((1 + ν)(1 - 2ν))"
    cells = "½κ(ΔA)²/A, A a cell's area" if m.dim == 2 else "½κ(ΔV)²/V, V a cell's volume"
    return (
        f"at nu = {m.nu:.6g}: μ = E/(2(1 + ν)) = {mu:.6g} Pa, {said} = {second:.6g} Pa; "
        f"t thickness, h spacing; energy by κ {cells}"
    )


def _engines(engine: str | None, advice: Advice, step: float | None, *, notes: bool) -> list[str]:
    """Table of the numbers that other programs take, with notes and sources if requested."""
    if engine is None:
        return ["numbers for other programs: --engine springs, --engine cells; formulas: -v"]
    m, springs = advice.material, engine == "springs"
    lam, mu = lame(3, m.E, m.nu)
    names = {"mu": mu, "lam": lam, "E": m.E, "rho": m.density, "t": m.thickness, "m": advice.mass}
    names |= {"lam2": lame(2, m.E, m.nu)[0]} | ({"dt": step} if step else {})
    each = [names | {"k": kind.constant, "L": kind.length} for kind in advice.kinds]
    rows = []
    table = Path(advise_package.__file__).with_name("engines.toml").read_text(encoding="utf-8")
    for row in tomllib.loads(table)["engine"]:
        if (row["takes"] != "elements") == springs and row.get("axes", m.dim) == m.dim:
            factor, number = row["factor"], "none"
            if "dt" in factor and not step:
                number = f"{factor}; give --step"
            elif factor:  # of our own table
                values = dict.fromkeys(f"{eval(factor, known):.6g}" for known in each)  # noqa: S307
                number = f"{factor} = {', '.join(values)} {row['unit']}"
            rows.append((row["name"], number, *([row["note"], row["source"]] if notes else [])))
    heads = ("program", f"of {advice.lattice}" if springs else "of the material", "note", "source")
    return ["", *align_table(heads[: len(rows[0])], rows)]


def _identify(args: argparse.Namespace) -> list[str]:
    """Lines about the elastic solid that given springs represent."""
    thickness = args.thickness
    if args.cubic:
        return identified_lines(identify_cubic(*args.cubic))
    if args.identify:
        from msvalidate.case.advise.identify_files import identify_files

        period = tuple(args.period) if args.period else None
        found = identify_files(Path(args.identify), period, args.density, thickness)
        return identified_lines(found, thickness)
    if args.lattice is None or args.spacing is None:
        raise ProblemError("--identify: give a springs.csv, or --lattice, --k1 .. and --spacing")
    require_one_of("--lattice", args.lattice, all_patterns())
    dim = all_patterns()[args.lattice]().dim
    density, note = mass_density(dim, args.density, thickness)
    kappa, given = args.kappa or (0.0, "")
    if ("Pa" if dim == 2 else "N/") in given:
        raise ProblemError(f"--kappa: {given}; give it in {UNIT[dim]}")
    k = tuple(getattr(args, name) for name in CONSTANTS if getattr(args, name) is not None)
    found = identify_lattice(args.lattice, k, args.spacing, kappa, density)
    return identified_lines(replace(found, whose=f"{found.whose}, {note}"), thickness)
