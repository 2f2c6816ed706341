"""Which elastic solid a simulator's law is, read from single steps of one block."""
