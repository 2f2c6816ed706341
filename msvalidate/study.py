"""``python -m msvalidate.study NAME``: the command line, by its first name."""

from msvalidate.cli.program import run

if __name__ == "__main__":
    run()
