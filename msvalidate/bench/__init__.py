"""Candidates, evidence and its rules, and results as files: the base of every study."""
