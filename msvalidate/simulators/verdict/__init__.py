"""Judgement of a simulator: state, causes, advice, report, page and record."""
