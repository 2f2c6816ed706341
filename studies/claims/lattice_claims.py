"""Sentences about springs, lattices and Poisson's ratio: sections 3, 5.1, 5.2 and 8."""

from __future__ import annotations

import numpy as np

from msvalidate.output.results import Results

from .record import (
    AT_LEAST,
    AT_MOST,
    FAILS,
    HOLDS,
    ONLY_IF,
    Check,
    Claim,
    column,
    finest,
    numbers,
    rows,
    unjudged,
    value,
)

SQUARE = "square"
FINITE, SOLIDS, TENSORS = "poisson/finite_size", "lattices/solids", "lattices/tensors"
LOADED = "lattices/random_surface_loaded"


def neighbours_off_eight(results: Results) -> float:
    """Farthest number of neighbours of a square lattice's point from 8."""
    return float(np.abs(column(results, SOLIDS, "springs_a_point", lattice=SQUARE) - 8).max())


def forces_a_point(results: Results) -> float:
    """Springs of a square lattice's point, its load and its viscous force."""
    return float(column(results, SOLIDS, "springs_a_point", lattice=SQUARE).max() + 2)


def diagonals_share(results: Results) -> float:
    """Part of the axial stiffness that diagonals carry, all springs being equal."""
    with_diagonals, without = (
        value(results, TENSORS, "numerical", lattice=name, rule="equal", row="xx", column="xx")
        for name in (SQUARE, "square 4")
    )
    return 1 - without / with_diagonals


def shear_without_diagonals(results: Results) -> float:
    """Shear stiffness of a square lattice without diagonals, over that were it isotropic."""
    return value(results, SOLIDS, "A", lattice="square 4")


def off_cell_formula(results: Results) -> float:
    """Farthest ratio from k2/(2 k1 + k2), of blocks of every size whose cells share springs."""
    blocks = rows(results, FINITE, lattice=SQUARE, weights="shared")
    blocks = blocks[blocks["loading"] != "clamped"]
    off = numbers(blocks, "nu_springs") - numbers(blocks, "nu_cell_formula")
    return float(np.abs(off).max())


def cell_off_cell_formula(results: Results) -> float:
    """The same of one cell alone, whose springs are whole."""
    cell = rows(results, FINITE, lattice=SQUARE, weights="equal", cells=1)
    return float(np.abs(numbers(cell, "nu_springs") - numbers(cell, "nu_cell_formula")).max())


def ratio_off_half(results: Results) -> float:
    """Farthest ratio from 1/2 of the lattice with k2 = 2 k1, along axes and diagonals."""
    row = rows(results, "poisson/incompressible", reading="the report, k2 = 2 k1")
    return max(abs(float(numbers(row, name)[0]) - 0.5) for name in ("nu_axis", "nu_diagonal"))


def least_anisotropy(results: Results) -> float:
    """Least distance of the anisotropy ratio from 1, of every rule for the square lattice."""
    return float(np.abs(column(results, SOLIDS, "A", lattice=SQUARE) - 1).min())


def other_anisotropy(results: Results) -> float:
    """The same of rules other than k2 = k1/2."""
    square = rows(results, SOLIDS, lattice=SQUARE)
    return float(np.abs(numbers(square[square["rule"] != "isotropic"], "A") - 1).min())


def least_random_ratio(results: Results) -> float:
    """Least mean ratio of random networks in the plane, of every rule for constants."""
    return float(column(results, "lattices/random_quoted", "nu_mean", axes=2).min())


def grid_neighbours(results: Results) -> float:
    """Neighbours of a point that Voronoi cells of a square grid give it."""
    return float(column(results, "lattices/zero_jitter", "neighbours", jitter=0).max())


def roughness_growth(results: Results) -> float:
    """Roughness of a loaded side in spacings, most spacings over fewest, in the plane."""
    table = rows(results, LOADED, axes=2)
    mean = table.groupby("spacings_a_side")["loaded_roughness"].mean()
    return float(mean.iloc[-1] / mean.iloc[0])


def roughness_growth_in_sides(results: Results) -> float:
    """The same in lengths of the side."""
    spacings = column(results, LOADED, "spacings_a_side", axes=2)
    return roughness_growth(results) * float(spacings.min() / spacings.max())


def spread_of_central_springs(results: Results) -> float:
    """Ratio along axes less that along diagonals, where that along axes is 1/2."""
    row = rows(results, "poisson/incompressible", reading="plane stress, nu = 1/2")
    return float(abs(numbers(row, "nu_axis")[0] - numbers(row, "nu_diagonal")[0]))


def ratio_off_asked(results: Results) -> float:
    """Farthest ratio from the one asked for, of square lattices with a volume energy."""
    table = rows(results, "lattices/any_ratio", lattice=SQUARE)
    return float(np.abs(numbers(table, "nu_found") - numbers(table, "nu_asked")).max())


def rubber_error(results: Results) -> float:
    """Deflection of the bent block nearest to 1/2 on the finest lattice, off mixed elements."""
    where = {"state": "plane_strain", "model": SQUARE}
    nearest = column(results, "lattices/rubber", "nu_rubber", **where).max()
    table = finest(results, "lattices/rubber", "cells_through", nu_rubber=nearest, **where)
    return float(np.abs(numbers(table, "deflection_difference")).max())


def other_isotropic_lattices(results: Results) -> float:
    """Lattices other than the square one that are isotropic and stand."""
    table = rows(results, SOLIDS, isotropic="yes", body="stands")
    return float((table["lattice"] != SQUARE).sum())


def solid_error(results: Results) -> float:
    """Worst case in space on its finest lattice, off elasticity."""
    table = rows(results, "displacement/solid", lattice="cubic 18")
    last = table.loc[table.groupby("case")["cells_high"].idxmax()]
    return float(np.abs(numbers(last, "against_own_body")).max())


def springs_short_of_rubber(results: Results) -> float:
    """1/2 less the largest ratio that central springs alone reach on squares."""
    table = results.table("lattices", "routes")
    rows = table[(table["lattice"] == "square") & (table["route"] == "springs")]
    return float(0.5 - numbers(rows, "nu_to").max())


ONE_CELL = Check(
    "poisson", "finite_size",
    "farthest ratio from k2/(2 k1 + k2), one cell alone with whole springs", "1",
    cell_off_cell_formula, AT_MOST, 1e-6,
    "an identity of one cell: what a linear solve leaves is far below a millionth",
)  # fmt: skip
CLAIMS = (
    Claim(
        13, "3, Figure 1", "A node is tied to its 8 neighbours.",
        HOLDS, "four along the axes and four along the diagonals",
        Check(
            "lattices", "solids", "farthest number of neighbours from 8", "1",
            neighbours_off_eight, AT_MOST, 0, "a count",
        ),
    ),
    Claim(
        12, "2, complexity", "At most 10 forces act on a node; the plane is meant, not 1D.",
        HOLDS, "8 springs, a load and a viscous force",
        Check(
            "lattices", "solids", "springs of a point in the plane, and two forces more", "1",
            forces_a_point, AT_MOST, 10, "a count; a chain in one dimension has 2 springs a point",
        ),
    ),
    Claim(
        16, "5.1, first lines", "Axis springs resist compression and stretch, diagonals shear.",
        ONLY_IF, "C11 = k1 + k2 and C66 = k2: diagonals carry both, axis springs no shear",
        Check(
            "lattices", "tensors", "part of the axial stiffness in the diagonals, k2 = k1", "1",
            diagonals_share, AT_MOST, 0.05, "what an engineer neglects beside the whole",
        ),
        "its half about shear alone is meant",
        Check(
            "lattices", "solids", "shear stiffness without diagonals, over an isotropic one's", "1",
            shear_without_diagonals, AT_MOST, 1e-6, "axis springs do not resist shear at all",
        ),
    ),
    Claim(
        17, "5.1, equation of the ratio", "Poisson's ratio is k2/(2 k1 + k2), from one square.",
        ONLY_IF, "in a block two cells share each axis spring: k2/(k1 + k2)",
        Check(
            "poisson", "finite_size",
            "farthest ratio from k2/(2 k1 + k2), blocks of shared springs", "1",
            off_cell_formula, AT_MOST, 1e-6,
            "a formula: what a linear solve leaves is far below a millionth",
        ),
        "the body is one cell alone", ONE_CELL,
    ),
    Claim(
        18, "5.1, last line", "k2 = 2 k1 makes the material incompressible.",
        ONLY_IF, "k2/(k1 + k2) is 2/3 along axes and k1/(k1 + 4 k2) is 1/9 along diagonals; one "
        "cell alone has k2/(2 k1 + k2), 1/2 along its axes and less along its diagonals",
        Check(
            "poisson", "incompressible", "farthest ratio from 1/2, along axes or diagonals", "1",
            ratio_off_half, AT_MOST, 0.01, "a hundredth of ratio is what rubber's is known to",
        ),
        # There the formula of 17 gives 1/2.
        "the body is one cell alone, pulled along its axes", ONE_CELL,
    ),
    Claim(
        19, "5.2, first paragraph", "Isotropic materials are difficult with this square lattice.",
        ONLY_IF, "isotropic where C66 = (C11 - C12)/2: k2 = k1/2 and ratio 1/3 alone",
        Check(
            "lattices", "solids", "least distance of the anisotropy ratio from 1, any rule", "1",
            least_anisotropy, AT_LEAST, 0.05, "a twentieth is a difference that is measured",
        ),
        "k2 is not k1/2, which is isotropic with ratio 1/3",
        Check(
            "lattices", "solids", "least distance of the anisotropy ratio from 1, k2 not k1/2",
            "1", other_anisotropy, AT_LEAST, 0.05, "a twentieth is a difference that is measured",
        ),
    ),
    Claim(
        20, "5.2, first paragraph", "Random points with Voronoi neighbours always give ratio 0.",
        FAILS, "random networks are isotropic in the mean and push sideways as they are pulled",
        Check(
            "lattices", "random_quoted", "least mean ratio in the plane, three rules", "1",
            least_random_ratio, AT_MOST, 0.02, "less than 0.02 a reader of a figure takes for 0",
        ),
    ),
    Claim(
        21, "5.2, second paragraph", "Voronoi neighbours of the square grid leave diagonals out.",
        HOLDS, "cells that meet in a corner share no edge",
        Check(
            "lattices", "zero_jitter", "neighbours of a point of a square grid", "1",
            grid_neighbours, AT_MOST, 4, "four along the axes; any diagonal would be a fifth",
        ),
    ),
    Claim(
        22, "5.2, second paragraph", "The surface is rough because there are few particles.",
        ONLY_IF, "roughness goes with the spacing: the surface looks alike at every number",
        Check(
            "lattices", "random_surface_loaded",
            "roughness in spacings, most particles over fewest", "1",
            roughness_growth, AT_MOST, 0.75,
            "were it the number, four times as many a side would leave much less: half way "
            "between no change and a half",
        ),
        "roughness is measured in lengths of the body, not in spacings",
        Check(
            "lattices", "random_surface_loaded",
            "roughness in lengths of the side, most particles over fewest", "1",
            roughness_growth_in_sides, AT_MOST, 0.75, "as for spacings",
        ),
    ),
    Claim(
        57, "8, third paragraph", "Tuning springs easily gives any Poisson's ratio, 0.5 too.",
        ONLY_IF, "central springs keep Cauchy's relation: isotropic at ratio 1/3 alone",
        Check(
            "poisson", "incompressible",
            "ratio along axes less that along diagonals, where the first is 1/2", "1",
            spread_of_central_springs, AT_MOST, 0.01, "a material has one ratio; a hundredth is "
            "what rubber's is known to",
        ),
        "an energy of volumes is added to the springs",
        Check(
            "lattices", "any_ratio", "farthest ratio from the one asked for, up to 0.499", "1",
            ratio_off_asked, AT_MOST, 1e-6, "closed forms give the constants",
        ),
    ),
    Claim(
        58, "8, third paragraph", "How to assemble isotropic rubber from springs is open.",
        ONLY_IF, "springs at k2 = k1/2 and a volume energy are isotropic at any ratio; central "
        "springs alone are isotropic at 1/3 in the plane and at no other",
        Check(
            "lattices", "rubber", "bent rubber block, finest lattice, off mixed elements", "1",
            rubber_error, AT_LEAST, 0.05, "open if nothing comes within the 5 % that an engineer "
            "takes for agreement",
        ),
        "central springs alone are allowed",
        Check(
            "lattices", "routes", "ratio of rubber less the largest by springs alone", "1",
            springs_short_of_rubber, AT_LEAST, 0.01,
            "a hundredth of ratio is what rubber's is known to",
        ),
    ),
    unjudged(
        59, "8, third paragraph", "Rubber's nonlinear law for springs is open.",
        "work on rubber's law will judge it: no spring here follows another law than Hooke's",
    ),
    Claim(
        63, "1, and reference [3]", "Solids in space can be built of springs too.",
        HOLDS, "a cubic lattice with 18 neighbours is isotropic at ratio 1/4",
        Check(
            "displacement", "solid", "worst case in space, finest lattice, off elasticity", "1",
            solid_error, AT_MOST, 0.05, "the 5 % that an engineer takes for agreement",
        ),
    ),
    Claim(
        64, "5.2, third paragraph", "Other lattices serve spring models as well.",
        HOLDS, "every vector set whose fourth moments are isotropic will do",
        Check(
            "lattices", "solids", "isotropic lattices that stand, besides the square one", "1",
            other_isotropic_lattices, AT_LEAST, 1, "one is enough",
        ),
    ),
)  # fmt: skip
