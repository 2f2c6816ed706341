"""Closed forms of dielectric films that stay uniform, and which pull-in is which.

A film of thickness h0 and thickness ratio l, under a voltage V, is squeezed by ½εE² where it cannot
widen and by εE² where its edges are drawn outwards as well ([Pelrine1998]), E = V/(l·h0). Where the
voltage that holds a ratio has a maximum in it, the film is pulled in there. Voltages are in V,
moduli in Pa, permittivities in F/m, lengths in m.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.optimize import brentq

from msvalidate.problem import LONGEST, ProblemError, SolverError
from msvalidate.problem.checks import finite_number, positive_number

CREASING_FIELD_THEORY = 1.03
CREASING_FIELD_EXPERIMENT = 0.85
"""True field over √(μ/ε) at which the surface of a bonded neo-Hookean film creases, computed and
measured: literature, not derived here [WangZhangZhao2011]."""
CREASING_WAVELENGTH = 1.5
"""Distance of creases over the thickness, from the same source."""
MOST_STRETCHED = 1e6
"""Stretch beyond which, and below the inverse of which, squares and cubes lose their digits."""
THINNEST = 1e-9
"""Thickness ratio below which nothing is looked for."""


class PullIn(NamedTuple):
    """Pull-in of a film: thickness ratio and voltage (V)."""

    thickness: float
    voltage: float


def pressure(
    ratio: float, *, axial: float = 1.0, diagonal: float = 0.5, stretch: float = 1.0
) -> float:
    """Pressure (Pa) that holds a square lattice with diagonals at a thickness ratio l, sides held.

    With its points scaled by λ along x and l along y, per width after the stretch:
    P = {k1·(1-l) + 2·k2·l·[√2/√(λ²+l²) - 1]}/λ.

    Source: closed form derived here: the derivative of the springs' energy by l.
    """
    l = positive_number("thickness ratio", ratio)  # noqa: E741  # the formula's
    k1, k2 = positive_number("axial", axial, "Pa"), positive_number("diagonal", diagonal, "Pa")
    wide = _stretched(stretch)
    diagonals = 2 * k2 * l * (math.sqrt(2) / math.hypot(wide, l) - 1)
    return (k1 * (1 - l) + diagonals) / wide


def relaxed_thickness(stretch: float, *, axial: float = 1.0, diagonal: float = 0.5) -> float:
    """Thickness ratio at which a stretched film of this lattice needs no pressure."""
    positive_number("axial", axial, "Pa")
    positive_number("diagonal", diagonal, "Pa")
    wide = _stretched(stretch)
    if wide == 1:
        return 1.0
    # Springs along y want a ratio of 1; diagonals √(2-λ²), or none where even that is too long.
    high = max(1.0, math.sqrt(max(2 - wide * wide, 0.0)))
    given = {"axial": axial, "diagonal": diagonal, "stretch": wide}
    return float(brentq(lambda ratio: pressure(ratio, **given), THINNEST, 2 * high, xtol=1e-15))


def voltage(
    ratio: float, *, height: float = 10.0, permittivity: float = 1.0, **springs: float
) -> float:
    """Voltage (V) that holds the lattice at a thickness ratio l, sides held: ½ε(V/(l·h0))² = P.

    Springs are given as for `pressure`.

    Source: the pressure ½εE² at a fixed area; [Pelrine1998] has εE², of films that widen.
    """
    held = pressure(ratio, **springs)
    if held < 0:
        raise ProblemError(f"thickness ratio: {ratio:g}; a voltage only squeezes, give a lower one")
    gap = float(ratio) * positive_number("height", height, "m")
    return gap * math.sqrt(2 * held / positive_number("permittivity", permittivity, "F/m"))


def pull_in(
    *,
    height: float = 10.0,
    axial: float = 1.0,
    diagonal: float = 0.5,
    permittivity: float = 1.0,
    stretch: float = 1.0,
) -> PullIn:
    """Pull-in of the lattice with its sides held: where l²·P(l) is largest.

    Source: closed form derived here, from `voltage`.
    """
    whole = relaxed_thickness(stretch, axial=axial, diagonal=diagonal)

    def slope(l: float) -> float:  # noqa: E741
        """d(l²P)/dl, times λ/l: above 0 in thin films, below it at rest."""
        across = stretch * stretch + l * l
        turn = math.sqrt(2) * (3 * across - l * l) / (across * math.sqrt(across))
        return axial * (2 - 3 * l) + 2 * diagonal * l * (turn - 3)

    ratio = float(brentq(slope, THINNEST, whole, xtol=1e-15))
    given = {"axial": axial, "diagonal": diagonal, "stretch": stretch}
    return PullIn(ratio, voltage(ratio, height=height, permittivity=permittivity, **given))


def thickness(
    volts: float, *, height: float = 10.0, permittivity: float = 1.0, **springs: float
) -> float:
    """Thickness ratio of the lattice at a voltage (V), on the branch that starts at rest.

    Springs are given as for `pressure`.

    Raises
    ------
    SolverError
        Beyond pull-in.
    """
    wanted = abs(finite_number("voltage", volts))
    end = pull_in(height=height, permittivity=permittivity, **springs)
    if wanted > end.voltage:
        raise SolverError(
            f"uniform slab: no thickness at {wanted:.6g} V; it is pulled in at "
            f"{end.voltage:.6g} V, stay below"
        )
    force = 0.5 * permittivity * (wanted / height) ** 2

    def excess(ratio: float) -> float:
        return ratio**2 * pressure(ratio, **springs) - force

    if excess(end.thickness) <= 0:  # pull-in itself, to rounding
        return end.thickness
    whole = relaxed_thickness(**({"stretch": 1.0} | springs))
    return float(brentq(excess, end.thickness, whole * (1 + 1e-12), xtol=1e-15))


def linear_stress_pull_in(modulus: float, height: float, permittivity: float = 1.0) -> PullIn:
    """Stress C·(1-l) at fixed area: V² = 2h²l²C(1-l)/ε is largest at l = 2/3, 8Ch²/(27ε).

    Source: closed form derived here.
    """
    stiff, tall = positive_number("modulus", modulus, "Pa"), positive_number("height", height, "m")
    square = 8 * stiff * tall**2 / (27 * positive_number("permittivity", permittivity, "F/m"))
    return PullIn(2 / 3, math.sqrt(square))


def biaxial_nominal_field(stretch: float) -> float:
    """Voltage over h0·√(μ/ε) of a free neo-Hookean film stretched by λ along both sides.

    σ = μ(λ²-λ⁻⁴) = εE² and E = (V/h0)·λ², so (V/h0)² = (μ/ε)·(λ⁻²-λ⁻⁸).

    Source: [ZhaoSuo2007].
    """
    wide = _widened(stretch)
    return math.sqrt(wide**-2 - wide**-8)


def biaxial_pull_in(modulus: float, height: float, permittivity: float = 1.0) -> PullIn:
    """Pull-in of a free neo-Hookean film of shear modulus μ: λ = 2^(1/3), thickness 2^(-2/3).

    Source: [ZhaoSuo2007].
    """
    wide = 2 ** (1 / 3)
    stiff, tall = (
        positive_number("shear modulus", modulus, "Pa"),
        positive_number("height", height, "m"),
    )
    unit = tall * math.sqrt(stiff / positive_number("permittivity", permittivity, "F/m"))
    return PullIn(wide**-2, unit * biaxial_nominal_field(wide))


def plane_strain_nominal_field(stretch: float) -> float:
    """Voltage over h0·√(μ/ε) of a neo-Hookean film free to stretch by λ along one side alone.

    σ = μ(λ²-λ⁻²) = εE² and E = (V/h0)·λ, so (V/h0)² = (μ/ε)·(1-λ⁻⁴): it has no maximum, hence no
    pull-in, and stays below 1: no film holds a voltage of h0·√(μ/ε).

    Source: the stress εE² of [Pelrine1998]; closed form derived here.
    """
    return math.sqrt(1 - 1 / _widened(stretch) ** 4)


def bonded_film_field(wavenumber: float) -> float:
    """True field over √(μ/ε) at which a wave on a bonded incompressible film costs nothing.

    Linear elasticity about the unstrained film, κ = k·h0. A normal pressure of a wave of amplitude
    u is resisted by 2μk·u·(cosh²κ + κ²)/(sinhκ·coshκ - κ), the shear-free surface of a layer on a
    rigid base, and fed by εE²·k·u·cothκ, as the field grows where the gap is smaller. The ratio
    falls with κ towards √2: short waves go first, and no wavelength is preferred without a surface
    energy.

    Source: closed form derived here.
    """
    wave = min(positive_number("wavenumber times thickness", wavenumber), 300.0)  # √2 from there on
    if wave < 1 / LONGEST:
        raise ProblemError(f"wavenumber times thickness: {wave:g}; give {1 / LONGEST:g} or more")
    if wave < 0.02:
        # sinhκ·coshκ - κ = ⅔κ³(1 + κ²/5 + ...) cancels below; what is left out is below κ⁴.
        resisted = (1 + 2 * wave**2) / (2 / 3 * wave**3 * (1 + wave**2 / 5))
    else:
        # Over cosh², so that long films do not overflow.
        decay = 1 / math.cosh(wave) ** 2
        resisted = (1 + wave**2 * decay) / (math.tanh(wave) - wave * decay)
    return math.sqrt(2 * resisted * math.tanh(wave))


def bonded_film_limit() -> float:
    """The same of short waves, √2."""
    return math.sqrt(2)


def _stretched(stretch: float) -> float:
    wide = positive_number("stretch", stretch)
    if not 1 / MOST_STRETCHED <= wide <= MOST_STRETCHED:
        raise ProblemError(f"stretch: {wide:g}; give {1 / MOST_STRETCHED:g} to {MOST_STRETCHED:g}")
    return wide


def _widened(stretch: float) -> float:
    wide = _stretched(stretch)
    if wide < 1:
        raise ProblemError(f"stretch: {wide:g}; a voltage only widens a film, give 1 or more")
    return wide
