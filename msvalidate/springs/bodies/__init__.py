"""Networks of bodies, and the spring constants that suit a body."""
