"""Numbers of your own tests, held to those that were committed: a plugin of pytest.

Fixture `msvalidate_baseline` compares what a test records with a file; ``--msvalidate-update``
with ``--msvalidate-reason`` writes what moved, if all tests of the run pass. See docs/baselines.md.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path

import pytest

from msvalidate_check import exchange
from msvalidate_check.baseline import (
    PYTEST,
    REASONS,
    RELATIVE,
    BaselineError,
    check_name,
    describe_move,
    differences,
    make_columns,
    read_columns,
    reasons_with,
    table_bytes,
    table_file,
)

FOLDER, UPDATE, REASON = "--msvalidate-baseline", "--msvalidate-update", "--msvalidate-reason"
INI = "msvalidate_baseline"


@dataclass
class Recording:
    """What one run of pytest records.

    Parameters
    ----------
    folder
        Of the baseline; None if the run names none.
    shown
        The same as the user named it.
    how
        The command that writes what moved.
    reason
        Why tables are written; "" if they are only compared.
    owner
        Table, in small letters -> the test that recorded it.
    moved
        Table -> its new content, of those that are to be written.
    said
        Lines for the end of the run.
    """

    folder: Path | None
    shown: str
    how: str
    reason: str
    owner: dict[str, str] = field(default_factory=dict)
    moved: dict[str, bytes] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)


class Baseline:
    """What a test holds its numbers to; fixture `msvalidate_baseline` gives one."""

    def __init__(self, recording: Recording, test: str) -> None:
        self._recording, self._test = recording, test
        self._names: set[str] = set()

    def check(
        self,
        name: str,
        values: Mapping[str, object],
        *,
        relative: float = RELATIVE,
        absolute: float = 0.0,
    ) -> None:
        """Compare numbers with those of the file ``pytest/NAME.csv`` of the baseline.

        Parameters
        ----------
        name
            Of the table, one of its own in the whole run.
        values
            Column -> a number, a word, or an array (rows,) of them, in a unit of your choice.
        relative
            How much of the kept number it may move, from 0 to below 1.
        absolute
            How much more it may move, in the column's unit: 0 or more.

        Raises
        ------
        AssertionError
            If a number moved, or there is no file; the text says where, by how much and what next.
        BaselineError
            If there is no folder, the name is taken, or a value is not finite.
        """
        __tracebackhide__ = True
        _check_limits(name, relative, absolute)
        columns = make_columns(self._take(name), values)
        folder = self._recording.folder
        if folder is None:
            raise BaselineError(
                f"baseline {name!r}: no folder to look in; run pytest with {FOLDER} DIR, or set "
                f"{INI} = DIR in pytest's settings"
            )
        lines = _compared(table_file(folder, name), columns, relative, absolute)
        self._recording.moved.pop(name, None)  # of a run of the same test before
        if lines and self._recording.reason:
            self._recording.moved[name] = table_bytes(columns)
        elif lines:
            said = "\n".join(f"  {line}" for line in lines)
            where = table_file(Path(self._recording.shown), name)
            raise AssertionError(
                f"baseline {name!r}, {where}:\n{said}\nif that is meant: {self._recording.how}"
            )

    def _take(self, name: object) -> str:
        """The name of a table, if no other test and no earlier call has it."""
        __tracebackhide__ = True
        taken = check_name(name)
        one = taken.casefold()  # as some systems take names of files
        owner = self._recording.owner.setdefault(one, self._test)
        if owner != self._test or one in self._names:
            raise BaselineError(
                f"baseline {taken!r}: {owner} recorded it already; give each table a name of its "
                "own"
            )
        self._names.add(one)
        return taken


def _check_limits(name: object, relative: float, absolute: float) -> None:
    __tracebackhide__ = True
    if not (isinstance(relative, Real) and 0 <= relative < 1):
        raise BaselineError(f"baseline {name!r}: relative is {relative!r}; give 0 to below 1")
    if not (isinstance(absolute, Real) and 0 <= absolute < float("inf")):
        raise BaselineError(f"baseline {name!r}: absolute is {absolute!r}; give 0 or more")


def _compared(
    path: Path, columns: Mapping[str, list[str]], relative: float, absolute: float
) -> list[str]:
    """What keeps a table from being the one in a file; one line if that cannot be read."""
    if not path.is_file():
        return ["no such file; nothing was ever recorded under this name"]
    try:
        kept = read_columns(path.read_bytes())
    except ValueError as error:
        return [f"the file cannot be read: {' '.join(str(error).split())}"]
    room = dict.fromkeys(columns, absolute)
    hint = "; a reference of 0 leaves no tolerance, so pass absolute= to check"
    return differences(columns, kept, relative=relative, absolute=room, hint=hint)


RECORDING = pytest.StashKey[Recording]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options, and the setting that stands for the folder."""
    group = parser.getgroup("msvalidate", "numbers held to a baseline")
    group.addoption(FOLDER, metavar="DIR", help="folder with the numbers as they were")
    group.addoption(
        UPDATE, action="store_true", help="write what moved or is new, if all tests pass"
    )
    group.addoption(REASON, metavar="TEXT", help=f"why it moved, for {REASONS} in the folder")
    parser.addini(INI, f"folder for {FOLDER}, from where this file is", default="")


def pytest_configure(config: pytest.Config) -> None:
    """Read the options.

    Raises
    ------
    pytest.UsageError
        If they do not go together, the folder is a file, or several processes would write it.
    """
    given, setting = config.getoption(FOLDER), str(config.getini(INI))
    update, reason = config.getoption(UPDATE), config.getoption(REASON)
    if update != (reason is not None):
        raise pytest.UsageError(f'{UPDATE} and {REASON} "..." go together; give both or none')
    if reason is not None and not (reason.strip() and reason.isprintable()):
        raise pytest.UsageError(f"{REASON} {reason!r}; say why in one line")
    if given is not None and not given.strip():
        raise pytest.UsageError(f"{FOLDER} {given!r} is no folder; name one")
    folder = Path(config.invocation_params.dir, given) if given else None
    if folder is None and setting:
        folder = (config.inipath.parent if config.inipath else config.rootpath) / setting
    if folder is not None and folder.exists() and not folder.is_dir():
        raise pytest.UsageError(f"{FOLDER} {given or setting}: a file; name a folder")
    if update and folder is None:
        raise pytest.UsageError(f"{UPDATE}: no folder to write to; give {FOLDER} DIR")
    if update and _spread(config):
        raise pytest.UsageError(f"{UPDATE}: one process writes a baseline; leave -n and --dist out")
    named = f"{FOLDER} {shlex.quote(given)} " if given else ""
    how = f'pytest {named}{UPDATE} {REASON} "why"'
    config.stash[RECORDING] = Recording(folder, given or setting, how, (reason or "").strip())


@pytest.fixture
def msvalidate_baseline(request: pytest.FixtureRequest) -> Baseline:
    """Compare numbers with committed ones: ``msvalidate_baseline.check("tip", {"u": 1.2e-4})``."""
    return Baseline(request.config.stash[RECORDING], request.node.nodeid)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Write what moved, if all else passed."""
    found = session.config.stash[RECORDING]
    if not found.reason or found.folder is None:
        return
    if exitstatus != pytest.ExitCode.OK:
        found.said.append("baseline left as it was: not all tests passed; mend that first")
    elif not found.moved:
        found.said.append("baseline left as it was: no number moved")
    else:
        try:
            _write(found.folder, found.moved, found.reason)
        except (OSError, BaselineError) as error:
            if isinstance(error, OSError):
                why = f"{error.strerror}: {error.filename}; mend that and run it again"
            else:
                why = str(error)
            found.said.append(f"baseline not written: {why}")
            session.exitstatus = pytest.ExitCode.USAGE_ERROR
        else:
            found.said.append(
                f"baseline renewed: {', '.join(sorted(found.moved))}; {REASONS} says why"
            )


def _write(folder: Path, tables: Mapping[str, bytes], reason: str) -> None:
    """Put tables and the reason into the folder: all of them, or none."""
    names = sorted(tables)
    path = folder / REASONS
    files = {".": {f"{name}.csv": tables[name] for name in names}}
    kept = {name: table_file(folder, name) for name in names}
    before = {name: path.read_bytes() for name, path in kept.items() if path.is_file()}
    moves = [describe_move(name, tables[name], before.get(name)) for name in names]
    exchange.replace_folder(
        folder / PYTEST,
        files,
        keep=True,
        beside=(path, lambda: reasons_with(path, PYTEST, names, reason, moves)),
    )


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Say what became of the baseline."""
    found = config.stash[RECORDING]
    for line in [*found.said, *_unasked(found, config)]:
        terminalreporter.write_line(line)


def _unasked(found: Recording, config: pytest.Config) -> list[str]:
    """A line on tables that no test of the run recorded; workers of xdist do not tell theirs."""
    if found.folder is None or _spread(config):
        return []
    kept = {path.stem for path in (found.folder / PYTEST).glob("*.csv")}
    left = sorted(name for name in kept if name.casefold() not in found.owner)
    return [f"baseline: no test of this run recorded {', '.join(left)}"] if left else []


def _spread(config: pytest.Config) -> bool:
    """Whether tests run in several processes, or this is one of these."""
    return hasattr(config, "workerinput") or getattr(config.option, "dist", "no") != "no"
