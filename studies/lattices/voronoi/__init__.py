"""Random lattices by Voronoi adjacency: which solid they are, their bodies, ratios of zero.

- `solids`: moduli of periodic networks over seeds, sizes, point sets and rules for the stiffness;
- `bodies`: networks in a box, stretched and clamped, and how rough their surfaces are;
- `zero`: how Poisson's ratio can come out at zero, as the report found.
"""
