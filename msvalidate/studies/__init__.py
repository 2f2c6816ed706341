"""The studies: a module or folder each, with ``run(candidate, setting=…) -> Evidence``, ``FAULTS``.

``FAULTS`` are negative controls: name -> keyword arguments of ``run`` under which it must fail.

In a checkout they stand in the folder ``studies`` at its top, installed beside this file. They are
imported under this name, so another package called ``studies`` is no obstacle. Folders that
`VARIABLE` names, separated as those of PATH are, join them: processes that are started from this
one find the same studies. Each such folder is a package of its own below this one, so that its
helpers and those of another folder do not meet.
"""

import hashlib
import os
import sys
from pathlib import Path
from types import ModuleType

VARIABLE = "MSVALIDATE_STUDIES"
"""The environment variable that names folders of a user's own studies."""

_HERE = Path(__file__).resolve().parent
_TOP = _HERE.parents[1]

OURS = _TOP / "studies" if (_TOP / "pyproject.toml").is_file() else _HERE
"""The folder of the studies that come with this package."""

__path__ = [str(OURS)]


def joined() -> list[str]:
    """Folders of a user's own studies, in the order named."""
    return [place for place in os.environ.get(VARIABLE, "").split(os.pathsep) if place]


def package(folder: str) -> str:
    """Name of the package that a joined folder is, here and in processes started from here."""
    name = f"{__name__}.of_{hashlib.sha256(folder.encode()).hexdigest()[:12]}"
    if name not in sys.modules:
        sys.modules[name] = ModuleType(name)
        sys.modules[name].__path__ = [folder]
    return name


for _folder in joined():
    package(_folder)
