"""Bodies of springs: from a problem to a network, and the constants that suit one body."""
