"""Measurement of a simulator's elastic law from single steps of one block."""
