"""From a material to the constants of an endless lattice, and back."""
