"""Stiffness of a plate of springs in tension"""

from functools import partial

import pandas as pd

from msvalidate import kit, lattice_network, square

BODY, E, NU, PULL = kit.Box((2.0, 1.0)), 1e5, 1 / 3, 10.0  # m, Pa, 1, Pa
BECAUSE = "springs that cells share make uniform strain exact; left is rounding"
RULES = (
    kit.Rule("strain along the pull, relative", 1e-9, "1", BECAUSE, table="strains",
             value=kit.Quotient("along", PULL / E), reference=1.0),
    kit.Rule("Poisson's ratio", 1e-9, "1", BECAUSE, table="strains", value="ratio", reference=NU),
)  # fmt: skip
COLUMNS = {"along": "strain along the pull (1)", "ratio": "strain across over that along (1)"}
FIGURE = kit.series("strains", title="A plate of springs, pulled", x="cells", y="ratio",
                    labels=("cells along the plate (1)", "Poisson's ratio (1)"))  # fmt: skip
FAULTS = {"springs 1 % softer": {"candidate": lambda *asked: 1.01 * kit.solve_springs(*asked)}}


def run(candidate=kit.solve_springs, setting=kit.FULL, questions=None):
    """All questions, or those named, for one candidate: displacements of a problem's network."""
    answer = partial(pull_plates, kit.check_displacements(candidate), setting)
    return kit.gather_evidence({"strains": answer}, questions)


def pull_plates(candidate, setting):
    """Plates of ever more cells, free to contract."""
    cells = (2, 4) if setting.quick else (2, 4, 8, 16)
    table = pd.DataFrame(setting.sweep(partial(pull_plate, candidate), cells, "plates"))
    last = f"Poisson's ratio is {table['ratio'].iloc[-1]:.6g}, and {NU:.6g} in elasticity."
    return kit.Evidence({"strains": table}, tolerances=RULES, columns=COLUMNS, findings=(last,),
                        figures={"strains": FIGURE})  # fmt: skip


def pull_plate(candidate, cells):
    """One row of the table."""
    left, right, bottom = map(BODY.side, ("left", "right", "bottom"))
    held = (kit.Support(left, (0.0, None)), kit.Support(bottom, (None, 0.0)))
    pull = (kit.Traction(right, (PULL, 0.0)),)
    problem = kit.Problem(BODY, kit.Isotropic(E, NU), held, pull)
    move = candidate(problem, lattice_network(problem, square(BODY, (2 * cells, cells))), "linear")
    along, across = move[:, 0].max() / 2.0, -move[:, 1].min() / 1.0  # over length and height
    return {"cells": 2 * cells, "along": along, "ratio": across / along}
