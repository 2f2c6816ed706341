"""Lattices of springs as simulators: homogenised solid, boundary weight, cantilever."""
