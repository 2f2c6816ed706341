"""Displacements from a file compared with elasticity, and the causes of their differences."""
