"""Order of the tests: the longest files first, so that several workers end together."""

from __future__ import annotations


def pytest_collection_modifyitems(items):
    items.sort(
        key=lambda item: (item.path.name != "test_studies.py", "studies" not in item.path.parts)
    )
