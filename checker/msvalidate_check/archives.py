"""Arrays of .npz files; what is too large is refused before memory is taken for it."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from msvalidate_check.errors import CheckError

Array = np.ndarray
LARGEST_FILE = 500_000_000
"""Bytes beyond which a file is not read."""
MOST_POINTS = 1_000_000
"""Most points whose numbers are read."""
PACKED = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
"""Ways of packing that NumPy uses; of others a few bytes become any number of them at once."""


def read_arrays(
    path: Path, wanted: Mapping[str, Sequence[str]], most_points: int = MOST_POINTS
) -> tuple[dict[str, tuple[str, Array]], tuple[str, ...]]:
    """Arrays of an archive: what each is for -> its name there and itself; and all names there are.

    Parameters
    ----------
    path
        A .npz file.
    wanted
        What for -> names, of which the first that is there is read and no other.
    most_points
        Three numbers a point are read, and no more.

    Raises
    ------
    CheckError
        If it is no archive of plain arrays, or one that is asked for is too large.
    """
    try:
        with zipfile.ZipFile(path) as packed:
            there = {each.filename.removesuffix(".npy"): each for each in packed.infolist()}
            found = {}
            for what, names in wanted.items():
                name = next((each for each in names if each in there), None)
                if name is not None:
                    found[what] = (name, _read(packed, there[name], name, most_points))
    except CheckError:
        raise
    except Exception as error:  # whatever the readers of archives and arrays stumble over
        why = " ".join(str(error).split()) or type(error).__name__
        raise CheckError(f"no .npz of plain arrays: {why}; write it again") from error
    return found, tuple(there)


def _read(packed: zipfile.ZipFile, member: zipfile.ZipInfo, name: str, most_points: int) -> Array:
    """An array, once the archive and its own header say that it is not larger than may be read."""
    _refuse_large(name, member.file_size, most_points)
    if member.compress_type not in PACKED:
        raise CheckError(f"{name}: not packed as NumPy does; write it again")
    with packed.open(member, mode="r") as file:
        head = np.lib.format.read_array_header_1_0
        if np.lib.format.read_magic(file) != (1, 0):
            head = np.lib.format.read_array_header_2_0
        shape, _, kind = head(file)
        _refuse_large(name, math.prod(shape) * kind.itemsize, most_points)
    with packed.open(member, mode="r") as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _refuse_large(name: str, size: int, most_points: int) -> None:
    most = 3 * np.dtype(np.longdouble).itemsize * most_points
    if size > most + (1 << 16):
        raise CheckError(f"{name}: {size:g} bytes when unpacked; the most is {most:g}")
