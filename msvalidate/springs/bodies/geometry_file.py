"""Meshes of .step and .stl files by gmsh, if it is installed.

Cells are quadratic, on a .step file's own faces; of an .stl file, which is its facets, linear.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.problem.progress import report_step
from msvalidate.springs.bodies.gmsh_mesher import NO_GMSH
from msvalidate.springs.bodies.process import LIMIT, run_limited

GEOMETRIES = (".step", ".stp", ".stl")
"""Suffixes of files that hold faces and no cells."""
MESHER = Path(__file__).with_name("gmsh_mesher.py")
MEMORY = 2e9
"""Bytes that gmsh may reserve: three times what a million cells take."""


@contextlib.contextmanager
def meshed_geometry(file: Path, size: float | None = None) -> Iterator[Path]:
    """Context manager of a temporary Gmsh file with the meshed geometry.

    The body is named "body". The faces of a solid are named "face 1", "face 2" and so on; the edges
    of plane faces are named "edge 1", "edge 2" and so on.

    Parameters
    ----------
    file
        A .step or .stp file of a solid or of faces in one plane, or an .stl file of a closed
        surface.
    size
        Largest size of the cells, in the file's unit of length. Default: 1/25 of the body's
        diagonal. Cells are smaller at curved surfaces, with or without a size.

    Raises
    ------
    ProblemError
        If gmsh is not installed, refuses the file, or makes no mesh of it within `LIMIT` seconds
        and `MEMORY` bytes.
    """
    message = f"mesh file {format_value(file.name)}"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mesh = folder / f"{file.name}.msh"
        words = [sys.executable, "-P", str(MESHER), str(file.absolute()), str(mesh), f"{size or 0}"]
        report_step("gmsh: meshing %s", file.name)
        code, _, complaint = run_limited(words, folder, LIMIT, MEMORY)
        if code == NO_GMSH:
            raise ProblemError(
                f"{message}: gmsh makes meshes of {file.suffix} files, and is not installed; pip "
                "install 'msvalidate[gmsh]', or write .msh, .vtu, .vtk or .inp"
            )
        if code == 0:
            yield mesh
            return
    if ";" in complaint:  # a refusal with its remedy
        raise ProblemError(f"{message}: {complaint}")
    if code is None or code < 0:
        complaint = "it takes longer" if code is None else f"it crashes ({signal.strsignal(-code)})"
    limits = f"in {LIMIT:g} s and {MEMORY / 1e9:g} GB"
    raise ProblemError(
        f"{message}: gmsh makes no mesh of it {limits}: {complaint or 'no reason'}; export it "
        "again, whole and closed, give a larger cell, or mesh it elsewhere"
    )
