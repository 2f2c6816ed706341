"""Files and folders replaced whole, under the name of 0.2: see `msvalidate_check.exchange`."""

from msvalidate_check.exchange import (
    ASIDE,
    EXCHANGE,
    NO_EXCHANGE,
    STAGED,
    Files,
    alone,
    exchange_folders,
    replace,
    replace_file,
    replace_folder,
    replace_one,
    stage_folder,
    write,
)

__all__ = [
    "ASIDE",
    "EXCHANGE",
    "NO_EXCHANGE",
    "STAGED",
    "Files",
    "alone",
    "exchange_folders",
    "replace",
    "replace_file",
    "replace_folder",
    "replace_one",
    "stage_folder",
    "write",
]
