"""Matrices alone: factors, their ordering, refinement, and sums in twice the digits."""
