"""List of the sheets: what each benchmark gives, asks and cites, from its question's numbers."""

from __future__ import annotations

from . import cantilever, cook, ellipse, hole, plate_springs, ring, thick_plate, three_point
from . import sheet_bodies as body
from .cases import VOLUME
from .curved import SPRINGS_ALONE
from .sheets import Sheet

GIGA, MEGA, KILO = 1e9, 1e6, 1e3
THEORY = "Timoshenko and Goodier, Theory of Elasticity, 1970"
NAFEMS = "The Standard NAFEMS Benchmarks, 1990"
MIRRORS = "Supports: mirror symmetry about both axes (rollers)."
PLANE = f"nu = {SPRINGS_ALONE:.3g} (springs alone), plane stress"
SHEETS = {
    "cook": Sheet(
        "Cook's membrane", "A tapered panel in bending and shear", body.draw_cook,
        (
            f"Material: E = {cook.MATERIAL.E:g} Pa, {PLANE}, 1 m thick.",
            "Supports: left edge clamped. Load: 1 N along y on the right edge.",
        ),
        "Cook 1974, J. Struct. Div. ASCE 100 (the body); the value is that of fine meshes.",
        ("cook",), (("u_y at (48, 52)", cook.MATERIAL.nu, "displacement uy at (48, 52) m"),),
        "cells along the width (1)", 3.0,
    ),
    "cantilever": Sheet(
        "Timoshenko's cantilever", "A beam under a parabolic shear at its end",
        body.draw_cantilever,
        (
            f"Material: E = {cantilever.MODULUS / MEGA:g} MPa, plane stress, 1 m thick.",
            "Supports: the left end moves as in the exact field.",
            f"Load: P = {cantilever.LOAD:g} N downwards on the right end.",
        ),
        f"{THEORY}, article 21: exact.",
        ("cantilever",),
        tuple(
            ("end deflection", nu, f"deflection of the end, nu = {nu:.3g}{more}")
            for nu, more in ((SPRINGS_ALONE, ""), (0.49, VOLUME), (0.3, VOLUME))
        ),
        "cells through the depth (1)", 2.1,
    ),
    "three_point": Sheet(
        "Three-point bending", "A beam under a load in the middle of its span",
        body.draw_three_point,
        (
            f"Material: E = {three_point.MODULUS / KILO:g} kPa, {PLANE}, 1 m thick.",
            "Supported: reactions P/2 over the end faces; ends of the axis kept.",
            "Clamped: both end faces held.",
        ),
        "beam theory with shear, κ = 5/6 (Reissner 1945), the load spread; elasticity "
        "differs by what the load does to the beam below it.",
        ("three_point",),
        tuple(
            (f"midspan, {kind}", SPRINGS_ALONE, f"deflection at midspan, {kind}")
            for kind in three_point.KINDS
        ),
        "cells through the height (1)", 3.0,
    ),
    "le1": Sheet(
        "NAFEMS LE1: elliptic membrane", "The stress at the tip of an elliptic hole",
        body.draw_membrane,
        (
            f"Material: E = {ellipse.MODULUS / GIGA:g} GPa, nu = 0.3; springs{VOLUME}.",
            f"Plane stress, {ellipse.THICKNESS:g} m thick.",
            MIRRORS, f"Load: {ellipse.PRESSURE / MEGA:g} MPa outwards on the outer ellipse.",
        ),
        f"{NAFEMS}, LE1; more digits by Kolosov's potentials, computed here.",
        ("le1",), (("σyy at (2, 0)", ellipse.RATIOS[0], "stress σyy at (2, 0) m"),),
        "cells from hole to rim or, of springs, per metre (1)",
    ),
    "hole": Sheet(
        "Kirsch: hole in an endless plate", "By how much a circular hole raises the stress",
        body.draw_hole,
        (
            f"Material: E = {hole.MODULUS / MEGA:g} MPa, {PLANE}, 1 m thick.",
            MIRRORS, "Load: the tractions of the endless plate on the rim, exact.",
        ),
        f"Kirsch 1898, Z. VDI 42; {THEORY}, article 35: exact.",
        ("hole",),
        (
            ("σyy at (a, 0)", SPRINGS_ALONE, "stress σyy across the tension, at (1, 0) m"),
            ("σxx at (0, a)", SPRINGS_ALONE, "stress σxx along the tension, at (0, 1) m"),
        ),
        "cells from hole to rim or, of springs, per radius (1)", 2.9,
    ),
    "ring": Sheet(
        "Lamé: thick ring under pressure", "How far a thick ring widens, and what holds it",
        body.draw_ring,
        (
            f"Material: E = {ring.MODULUS / MEGA:g} MPa, {PLANE}, 1 m thick.",
            f"{MIRRORS} Load: {ring.PRESSURE / KILO:g} kPa inside.",
        ),
        f"Lamé 1852; {THEORY}, article 28: exact.",
        ("ring",),
        (
            (ring.MOVED, SPRINGS_ALONE, "radial displacement of the inside"),
            (ring.HOOP, SPRINGS_ALONE, "hoop stress σθθ on the inside"),
        ),
        "cells from inside to outside (1)",
    ),
    "le10": Sheet(
        "NAFEMS LE10: thick plate", "The stress at the hole of a thick plate under pressure",
        body.draw_plate,
        (
            f"Material: E = {thick_plate.MODULUS / GIGA:g} GPa, nu = 0.3; springs{VOLUME}.",
            f"{MIRRORS} Rim held as above.",
            f"Load: {thick_plate.PRESSURE / MEGA:g} MPa from above.",
        ),
        f"{NAFEMS}, LE10. Meshes have no limit at a line support: see the figure le10.",
        ("le10", "le10_springs"),
        (
            ("σyy at (2, 0, 0.6)", thick_plate.NU, "stress σyy at (2, 0, 0.6) m"),
            (plate_springs.SINKING + ", rim held", thick_plate.NU,
             "sinking at (2, 0, 0.3) m, whole rim held upwards"),
        ),
        "cells from hole to rim or, of springs, through the thickness (1)", 2.8,
    ),
}  # fmt: skip
"""Name of a question -> its sheet."""
