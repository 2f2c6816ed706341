"""Lattices and constants for a material, and materials identified from springs."""
