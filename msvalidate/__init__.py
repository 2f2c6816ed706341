"""Validation of spring networks against elasticity theory and independent finite elements.

Nothing is imported here: ``python -m msvalidate.study --help`` must not wait for numpy. Import the
module that holds what you need, ``from msvalidate.network import Network``.
"""

__version__ = "0.1.0"
