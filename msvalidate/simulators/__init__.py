"""Simulators that others wrote: asked through files, gated, probed, and explained."""
