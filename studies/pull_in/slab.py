"""The slab that every question is about, its uniform compression, and how pictures name things.

A slab of square-8 lattice stands bonded on a rigid base, electrodes on both faces. In an infinite
one every layer keeps its width and is pressed to the part l of its height: springs up a cell give
the stress

    P(l) = k1(1 - l) + 2·k2·l·[√(2/(1 + l²)) - 1]

over the reference area, and a uniform field E = V/(l·h) pulls with ½εE², so V² = 2h²l²P(l)/ε. That
is `msvalidate.dielectric.actuator.uniform`; here are the numbers of the slab and nothing to solve.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.actuator import uniform

HEIGHT = 10.0
"""Of the slab (m)."""
LENGTH = 60.0
"""Of the bonded slab (m): the report's 61 x 11 particles."""
AXIAL, DIAGONAL = 1.0, 0.5
"""Spring constants (N/m): isotropic at no load, C11 = 1.5, C12 = C66 = 0.5 N/m, a ratio of 1/3."""
SHEAR = DIAGONAL
"""Shear modulus (N/m, for a depth of 1 m in Pa) of the lattice at no load."""
PERMITTIVITY = 1.0
"""(F/m), inside the slab and around it."""
NATURAL = float(np.sqrt(SHEAR / PERMITTIVITY))
"""√(μ/ε) of the lattice (V/m): the unit in which fields of different materials compare."""
PULL_IN = uniform.pull_in(height=HEIGHT, axial=AXIAL, diagonal=DIAGONAL, permittivity=PERMITTIVITY)
"""Of the infinite slab: thickness (1), and voltage (V)."""
REACH = HEIGHT
"""Distance (m) from the slab's ends beyond which the field between the electrodes is even: what the
edges add falls as exp(-2π·distance/h) or so."""
