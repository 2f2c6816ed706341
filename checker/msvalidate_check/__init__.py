"""Reference fields, a checker of yours against them, and baselines of your own numbers."""

__version__ = "0.1.0"
