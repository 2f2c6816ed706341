"""Networks of springs: lattices, constants, equilibria, motions and the bodies that they fill."""
