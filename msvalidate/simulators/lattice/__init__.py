"""Lattices of springs as simulators: homogenised solid, boundary weight, bodies at rest."""
