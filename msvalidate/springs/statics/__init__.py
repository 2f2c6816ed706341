"""Equilibria: solved, refined, followed along a load, and the stress in them."""
