"""How the frozen set of cases is made: `python -m cases.make --help`."""
