"""Write the table of options in docs/command-line.md from the table of arguments.

python docs/write_options.py
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

from msvalidate.cli.arguments import COMMANDS, options_of

PAGE = Path(__file__).resolve().with_name("command-line.md")
HEAD = "| option | commands | meaning | default |\n| --- | --- | --- | --- |\n"


def option_table() -> str:
    """Table of all options with their commands, meaning and defaults.

    Raises
    ------
    ValueError
        If an option has two meanings.
    """
    meanings: dict[str, str] = {}
    commands: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for name, command in COMMANDS.items():
        for option, settings in options_of(name).items() if "act" in command else ():
            if not option.startswith("-") or name not in settings.get("of", [name]):
                continue
            words = settings.get("metavar") or settings.get("choices")
            value = f" {{{','.join(words)}}}" if isinstance(words, list) else f" {words or ''}"
            title = f"`{option.split()[0]}{value.rstrip()}`"
            meaning = settings["help"]
            if meanings.setdefault(option, f"{title}\0{meaning}") != f"{title}\0{meaning}":
                raise ValueError(f"{option} of {name}: {meaning}; it has another meaning")
            default = settings.get("otherwise", settings.get("default"))
            commands[option]["" if default in (None, []) else str(default)].append(f"`{name}`")
    return HEAD + "".join(
        _row(*meanings[option].split("\0"), commands[option])
        for option in sorted(meanings, key=str.lower)
    )


def _row(title: str, meaning: str, commands: dict[str, list[str]]) -> str:
    """Row of an option; defaults that differ name their commands."""
    names = [name for group in commands.values() for name in group]
    every = len(names) == sum("act" in command for command in COMMANDS.values())
    shown = [
        f"{default} ({', '.join(group)})" if len(commands) > 1 else default
        for default, group in commands.items()
        if default
    ]
    cells = (title, "all" if every else ", ".join(names), meaning, "; ".join(shown))
    return f"| {' | '.join(cells)} |\n"


def page() -> str:
    """Page with the table in place of the one that it has."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(HEAD)
    return before + option_table() + "\n" + rest.partition("\n\n")[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
