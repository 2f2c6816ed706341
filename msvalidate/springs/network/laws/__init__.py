"""Constitutive laws of springs, and volume energies of cells."""
