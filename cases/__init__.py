"""A frozen set of elastic cases (`v1`), and what makes it (`make`)."""
