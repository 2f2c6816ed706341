"""The studies: a module or folder each, with ``run(candidate, setting=…) -> Evidence``, ``FAULTS``.

``FAULTS`` are negative controls: name -> keyword arguments of ``run`` under which it must fail.

In a checkout they stand in the folder ``studies`` at its top, installed beside this file. They are
imported under this name, so another package called ``studies`` is no obstacle. Folders that
`VARIABLE` names, separated as those of PATH are, join them: processes that are started from this
one find the same studies.
"""

import os
from pathlib import Path

VARIABLE = "MSVALIDATE_STUDIES"
"""The environment variable that names folders of a user's own studies."""

_HERE = Path(__file__).resolve().parent
_TOP = _HERE.parents[1]

OURS = _TOP / "studies" if (_TOP / "pyproject.toml").is_file() else _HERE
"""The folder of the studies that come with this package."""


def joined() -> list[str]:
    """Folders of a user's own studies, in the order named."""
    return [place for place in os.environ.get(VARIABLE, "").split(os.pathsep) if place]


__path__ = [str(OURS), *joined()]
