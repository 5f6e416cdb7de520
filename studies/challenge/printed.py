"""Compare values that were printed elsewhere with the answers on layered ground.

``python -m ringwear.studies.challenge.draw --tables`` writes `printed_values.csv`.
"""

from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from .answers import read_answers
from .problems import FOLDER, name_of, problem_named

FILE = FOLDER / "printed_values.csv"


class Printed(NamedTuple):
    """Describe a printed value.

    Parameters
    ----------
    source : where it was printed
    problem : number of the problem that has the right value
    case : columns of the case in the answers of the problem
    quantity : name in the answers
    value : as it was printed, in the unit of the answers
    """

    source: str
    problem: str
    case: Mapping[str, float]
    quantity: str
    value: str


# stiffnesses of a layer with nu = 0.3, by the radius over the thickness
HAYES = "Hayes, Keer, Herrmann, Mockros, J. Biomech. 5 (1972), 541"
STIFFNESSES = {
    0.2: "1.207",
    0.4: "1.472",
    0.6: "1.784",
    0.8: "2.124",
    1.0: "2.480",
    1.5: "3.400",
    2.0: "4.336",
}
# the row at the surface; compression is positive there
KENPAVE = "KENPAVE, as in `Validation/Kenpave.csv` of PyMastic"
SURFACE = {"depth": 0.0, "layer": 1.0}
PRINTED = (
    *(
        Printed(
            HAYES,
            "13",
            {"radius_over_thickness": radius_over_thickness, "poisson_ratio": 0.3},
            "stiffness",
            value,
        )
        for radius_over_thickness, value in STIFFNESSES.items()
    ),
    Printed(KENPAVE, "15", SURFACE, "displacement", "0.02252"),
    Printed(KENPAVE, "15", SURFACE, "stress_rr", "-259.181"),
)


def printed_values() -> pd.DataFrame:
    """Return the printed and the right values, and the error of the former relative to the latter.

    The difference is that of the two methods which compute the right value.
    """
    rows = []
    for printed in PRINTED:
        problem = problem_named(printed.problem)
        answers = read_answers(problem)
        wanted = pd.Series({**printed.case, "quantity": printed.quantity})
        (answer,) = answers[(answers[wanted.index] == wanted).all(axis=1)].to_dict("records")
        error = float(printed.value) / float(answer["value"]) - 1
        where = ", ".join(f"{name} = {number:g}" for name, number in printed.case.items())
        rows.append(
            {
                "source": printed.source,
                "problem": name_of(problem),
                "where": where,
                "quantity": printed.quantity,
                "printed": printed.value,
                "right": answer["value"],
                "error": f"{error:.1e}",
                "difference": f"{answer['difference']:.1e}",
                "methods": answer["methods"],
            }
        )
    return pd.DataFrame(rows)
