"""Observed values, tolerances and verdicts, and the execution of studies."""
