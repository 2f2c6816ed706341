"""Where a published table of springs beside elasticity was sought, and what could be had of it.

In the order of the table: [Brisard2021, Hansen1996, Golec2020, Golec2018, KotNagahashiSzymczak2015,
KotNagahashi2015, Baudet2009, LloydSzekelyHarders2007, vanGelder1998, OstojaStarzewski2002, Kot2021,
LiHe2026, SuryawanshiGupta2023].
"""

from __future__ import annotations

import pandas as pd

BEGINNING = "abstract and introduction only"
SOURCES = (
    (
        "Brisard 2021",
        "blog, sbrisard.github.io, posts of 9, 12 and 13 May; not refereed",
        "all: table, closed forms, geometry, constants, loads, supports",
        "row by row",
    ),
    (
        "Hansen, Skalak, Chien and Hoger 1996",
        "Biophysical Journal 70, from page 146",
        "abstract: two moduli to two digits; not how random the networks, how large the patch",
        "the two moduli",
    ),
    (
        "Golec, Palierne, Zara, Nicolle and Damiand 2020",
        "Visual Computer 36, 809-825, doi:10.1007/s00371-019-01663-0; tel-01761851",
        BEGINNING,
        "none",
    ),
    (
        "Kot, Nagahashi and Szymczak 2015",
        "Visual Computer 31, 1339-1350, doi:10.1007/s00371-014-1015-5",
        BEGINNING,
        "none",
    ),
    (
        "Kot and Nagahashi 2015",
        "GRAPP 2015, SciTePress 53036",
        "abstract, introduction and a caption without results",
        "none",
    ),
    (
        "Baudet, Beuve, Jaillet, Shariat and Zara 2007, 2009",
        "LIRIS report hal-01493735; WSCG 2009, 145-152, hal-00994456",
        BEGINNING,
        "none",
    ),
    (
        "Lloyd, Szekely and Harders 2007",
        "IEEE Transactions on Visualization and Computer Graphics",
        BEGINNING,
        "none",
    ),
    ("Van Gelder 1998", "Journal of Graphics Tools 3", BEGINNING, "none"),
    (
        "Ostoja-Starzewski 2002",
        "Applied Mechanics Reviews 55, 35-59",
        "abstract only",
        "none",
    ),
    ("Kot 2021", "ChemEngineering 5(1), 3, doi:10.3390/chemengineering5010003", BEGINNING, "none"),
    ("Li and He 2026", "arXiv:2605.15209", "abstract only", "none"),
    (
        "Suryawanshi and Gupta 2023",
        "Journal of Mechanics of Materials and Structures 18, 143-168",
        "abstract only",
        "none",
    ),
)
"""Source, reference, what could be had, and what is used of it here."""
COLUMNS = {
    "paper": "authors and year",
    "reference": "where it was published",
    "had": "what of it could be had when this was written",
    "used": "what is compared here",
}


def table() -> pd.DataFrame:
    """The table `published_sources`."""
    return pd.DataFrame(SOURCES, columns=list(COLUMNS))


def without_numbers() -> list[str]:
    """Sources of which nothing could be compared."""
    return [source for source, _, _, used in SOURCES if used == "none"]
