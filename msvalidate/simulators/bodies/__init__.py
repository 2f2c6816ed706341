"""Bodies that a simulator brings to rest, and what each owes to which cause."""
