"""`python -m msvalidate_check` is the command `msvalidate-check`."""

from msvalidate_check.command import run

raise SystemExit(run())
