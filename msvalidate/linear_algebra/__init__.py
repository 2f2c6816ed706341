"""Matrices alone: factors, their ordering, and refinement."""
