"""``python -m msvalidate``: the command line."""

from msvalidate.cli.program import run

if __name__ == "__main__":
    run()
