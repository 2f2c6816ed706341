"""Files that no reader can hold: one line, exit code 2, before memory is taken for them."""

import io
import runpy
import tracemalloc
import zipfile

import numpy as np
import pytest

from msvalidate_check import command as program
from tests.checker.mutated import CASE, try_all

ASKED = ("field", CASE.name)
MOST = 100_000_000
"""Bytes that may be held while a file of a few is refused."""


def test_changed_files_end_in_a_verdict_or_in_one_line():
    told = try_all(150)
    assert told[2] > 50
    assert told[0] + told[1] > 20


@pytest.mark.slow
def test_thousands_of_changed_files_end_in_a_verdict_or_in_one_line():
    assert try_all(12_000, seed=15).total() == 12_000


def said_of(path, capsys):
    """Exit code, what is said, and the most bytes held."""
    tracemalloc.start()
    code = program.run([*ASKED, str(path)])
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    out, err = capsys.readouterr()
    return code, out + err, most


def npy(values, shape=None):
    """A .npy file, whose header may promise another shape."""
    content = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        content,
        {"descr": values.dtype.str, "fortran_order": False, "shape": shape or values.shape},
    )
    return content.getvalue() + values.tobytes()


def test_what_an_archive_would_unpack_to_is_looked_at_before(tmp_path, capsys):
    path, u = tmp_path / "a.npz", np.zeros((6_200_000, 2))
    np.savez_compressed(path, displacement=u)
    assert path.stat().st_size < 200_000
    code, said, most = said_of(path, capsys)
    assert (code, said.count("\n"), most < MOST / 10) == (2, 1, True)
    assert "bytes when unpacked; the most is" in said
    np.savez_compressed(path, displacement=CASE.wanted, other=u)
    code, said, most = said_of(path, capsys)
    assert (code, most < MOST / 10) == (0, True)
    for kind, content, words in (
        (zipfile.ZIP_DEFLATED, npy(u[:9], (10**12, 2)), "1.6e+13 bytes when unpacked"),
        (zipfile.ZIP_DEFLATED, npy(u[:9], (10**6, 2)), "no .npz of plain arrays"),
        (zipfile.ZIP_BZIP2, npy(CASE.wanted), "not packed as NumPy does"),
        (zipfile.ZIP_STORED, npy(np.array([b"x" * 9] * 9)), "displacement: not numbers"),
    ):
        with zipfile.ZipFile(path, "w", kind) as packed:
            packed.writestr("displacement.npy", content)
        code, said, most = said_of(path, capsys)
        assert (code, words in said, most < MOST) == (2, True, True), said


def test_a_table_of_too_many_lines_is_refused_while_it_is_read(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("msvalidate_check.fields.MOST_POINTS", 1000)
    path = tmp_path / "a.csv"
    path.write_text("ux,uy\n" + "1,1\n" * 1000)
    assert said_of(path, capsys)[1].endswith(
        "a.csv: more than 1000 lines, the most that are read\n"
    )
    for content, words in (
        ("ux,uy,ux\n", "column ux is there twice"),
        ("ux,uy\n" + "1" * 200_000 + ",1\n", "field larger than field limit"),
        ("ux,uy\n1\0,1\n", "a.csv: "),
        ("", "columns none"),
        ('"u\n",uy\n', "a.csv: columns u, uy; name them"),
    ):
        path.write_text(content)
        code, said, _ = said_of(path, capsys)
        assert (code, words in said, said.count("\n")) == (2, True, 1), said


def test_a_fault_of_the_program_is_no_verdict(tmp_path, capsys, monkeypatch):
    path = tmp_path / "a.npz"
    np.savez(path, displacement=CASE.wanted)
    monkeypatch.setattr(program, "check", lambda *_, **__: 1 / 0)
    code, said, _ = said_of(path, capsys)
    assert code == program.FAULT == 3
    assert (
        said
        == "msvalidate-check: a fault of the program itself: ZeroDivisionError: division by zero\n"
    )


def test_the_package_runs_as_its_command_does(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["msvalidate_check", "list"])
    with pytest.raises(SystemExit) as end:
        runpy.run_module("msvalidate_check", run_name="__main__")
    assert (end.value.code, "cook_plane_strain" in capsys.readouterr().out) == (0, True)
