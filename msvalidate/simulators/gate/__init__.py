"""Checks that a simulator must pass before its numbers count."""
