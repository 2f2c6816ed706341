"""Motion: integrators, what they keep and lose, and natural frequencies."""
