"""Cases: a user's own body and field, from a file to a verdict."""
