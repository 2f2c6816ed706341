"""Compiled loops over charges: potentials, forces and fluxes of segments and polygons."""
