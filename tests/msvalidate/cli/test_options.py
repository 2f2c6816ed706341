"""Options mean the same in every command, and help texts have one form."""

import json
import re
import runpy
import tomllib
from pathlib import Path

import pytest

from msvalidate import ProblemError, __version__, read_case
from msvalidate.case.file.units import UNITS
from msvalidate.cli.arguments import COMMANDS, USAGE, options_of, parse
from msvalidate.cli.program import main

ROOT = Path(__file__).parents[3]
WRITER = runpy.run_path(str(ROOT / "docs" / "write_options.py"))
LANGUAGE = tomllib.loads((ROOT / "tests" / "language.toml").read_text("utf-8"))
COMPLETE = {"check", "list", "report", "study list", "case schema", "adapter laws"}
"""Commands that need no arguments."""
BANNED = {*LANGUAGE["names"].split()} - {"each", "own"}
OPENING = {*LANGUAGE["opening"].lower().split(), "a", "an", "the", "this", "only", "to", "in", "if"}


@pytest.fixture
def ending(capsys):
    """Parse words that end the program; return the exit code and standard output."""

    def end(*words):
        with pytest.raises(SystemExit) as error:
            parse(words)
        return error.value.code, capsys.readouterr().out

    return end


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_prints_its_version_its_page_and_its_help(name, ending):
    words = name.split()
    assert ending(*words, "--version") == (0, f"msvalidate {__version__}\n")
    code, text = ending(*words, "--help")
    page = text.splitlines()[-1].removeprefix("documentation: ")
    assert code == 0
    assert (ROOT / page).is_file()
    if name in COMPLETE:
        parse(words)
    else:
        assert ending(*words) == (USAGE, text)


@pytest.mark.parametrize("name", ["check", "list", "report"])
def test_a_complete_command_reports_its_errors(name, ending, monkeypatch):
    monkeypatch.setenv("MSVALIDATE_STUDIES", "nowhere")
    assert ending(name) == (USAGE, "")


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "study list"])
def test_help_texts_have_one_form(name, ending):
    page = " ".join(ending(*name.split(), "--help")[1].split())
    for option, settings in options_of(name).items():
        text = settings["help"]
        assert text.split()[0].strip(",:").lower() not in OPENING, option
        assert not text.endswith("."), option
        assert not BANNED & {*text.split()}, option
        assert "default" not in text, option
        default = settings.get("otherwise", settings.get("default"))
        if name in settings.get("of", [name]) and default not in (None, "", []):
            assert f"{' '.join(text.split())} (default: {default})" in page, option


def test_the_table_of_options_is_that_of_the_arguments():
    stored = (ROOT / "docs" / "command-line.md").read_text("utf-8")
    assert WRITER["page"]() == stored, "python docs/write_options.py"


def test_an_option_with_two_meanings_is_rejected(monkeypatch):
    monkeypatch.setitem(COMMANDS["case judge"]["options"], "--set", {"help": "set of points"})
    with pytest.raises(ValueError, match="--set of case judge: set of points"):
        WRITER["option_table"]()


CASE = """schema = 1
body = { box = [4, 1], unit = "cm" }
support = [{ on = "left", value = 0 }]
material = { E = 1e5, nu = 0.3, state = "plane_stress", thickness = 1, density = 1 }
"""
ADVISE = {"E": "1e5", "nu": ".3", "thickness": "1", "spacing": "1"}
TEXTS = [
    ("E", "70 GPa", 70e9),
    ("E", "70GPa", 70e9),
    ("E", "70 GP", None),
    ("density", "2.7 g/cm3", 2700.0),
    ("thickness", "6 mm", 0.006),
    ("thickness", "6mm", 0.006),
    ("thickness", "6 Pa", None),
]


@pytest.mark.parametrize(("key", "text", "value"), TEXTS)
def test_units_are_the_same_in_case_files_advise_and_adapter_check(key, text, value, tmp_path):
    def case():
        content = re.sub(rf"\b{key} = [\d.e]+", f'{key} = "{text}"', CASE)
        (tmp_path / "a.toml").write_text(content, encoding="utf-8")
        return getattr(read_case(tmp_path / "a.toml").problem.material, key)

    def advise():
        options = (ADVISE | {key: text}).items()
        words = [word for name, each in options for word in (f"--{name}", each)]
        return getattr(parse(["advise", *words]), key)

    def check():
        args = parse(["adapter", "check", "a.py", f"--{key}", text])
        return vars(args)[{"E": "modulus"}.get(key, key)]

    for read in (case, advise, *[check][: key != "thickness"]):
        if value is None:
            with pytest.raises((SystemExit, ProblemError)):
                read()
        else:
            assert read() == pytest.approx(value, rel=1e-15)


def test_every_quantity_of_a_case_file_takes_a_unit(tmp_path, capsys):
    main(["case", "schema"])
    tables = json.loads(capsys.readouterr().out)["$defs"].values()
    items = [item for table in tables for item in table["properties"].items()]
    assert {key for key, each in items if "['number', 'string']" in str(each)} == set(UNITS)
    load = 'load = [{ at = { x = "40 mm", y = [0, "1 cm"] }, traction = [0, "-10 kPa"] }]\n'
    text = CASE.replace("[4, 1]", '["40 mm", 1]') + load
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    problem = read_case(tmp_path / "a.toml").problem
    assert problem.domain.size == (0.04, 0.01)
    assert problem.loads[0].traction == (0.0, -1e4)
    (tmp_path / "a.toml").write_text(text.replace("kPa", "kp"), encoding="utf-8")
    with pytest.raises(ProblemError, match=r"line 5: load 1\.traction 2: '-10 kp'; .*: Pa, kPa"):
        read_case(tmp_path / "a.toml")
