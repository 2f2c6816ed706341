# SPDX-License-Identifier: MIT
"""Look which versions of the simulators are the newest, so that old records show as stale.

    python -m simulators.newest

asks the package index that pip is set up for, and writes studies/simulators/data/newest.json: the
versions, and the day that they were looked at. The study takes its records' age from there and not
from the clock, so that it is the same whenever it runs.
"""

from __future__ import annotations

import re
import subprocess
import sys
from datetime import UTC, datetime

from simulators.environments import HERE, packages, save

LIMIT = 120.0


def main() -> int:
    """Write what was found; 1 if a program's versions could not be had, which keeps the file."""
    programs = sorted(path.stem for path in (HERE / "requirements").glob("*.txt"))
    versions = {name: _newest(name) for name in programs}
    unknown = [name for name, version in versions.items() if not version]
    if unknown:
        print(f"no versions of {', '.join(unknown)}; is there a package index?", file=sys.stderr)
        return 1
    found = {"looked_at": datetime.now(UTC).date().isoformat(), "programs": versions}
    save("newest.json", found)
    for name, version in versions.items():
        own = [key for key in packages(name) if key.startswith(f"{name}==")]
        print(f"{name}: {version} (pinned: {own[0].partition('==')[2] if own else '?'})")
    return 0


def _newest(name: str) -> str:
    """The newest version of a package; "" if nobody tells."""
    words = [sys.executable, "-m", "pip", "index", "versions", name]
    try:
        told = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return ""
    match = re.match(rf"{name} \(([^)]+)\)", told.stdout)
    return match[1] if match else ""


if __name__ == "__main__":
    raise SystemExit(main())
