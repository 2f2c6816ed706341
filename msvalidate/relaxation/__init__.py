"""Rest by motion: methods that let a network move until it is at rest."""
