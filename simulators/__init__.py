"""Adapters of simulators, and what records what they answer. Outside the wheel."""
