"""The figures of a check: those of a run, and the errors of a refinement over its sizes."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ..figures.catalogue import PICTURES, Picture
from ..study.draw import draw, titled
from .account import REFINEMENT, shows_others
from .refinement import order_in_words

if TYPE_CHECKING:
    from .check import Check

# caption of the figure of the difference in a check, in place of that of a run
DIFFERENCE = (
    "The checked results minus ours: pressure, worn profile and displacement along the radius, "
    "relative to the norms of ours, with our error estimate as a band; and the same differences "
    "over radius and time, with the largest one marked."
)
FILES = (*(picture.file for picture in PICTURES), REFINEMENT)
"""Files of the figures that a check may have."""


def pictures(check: "Check") -> list[Picture]:
    """Return the figures of a check, those that show the checked results first."""
    refinement = Picture(
        REFINEMENT,
        "Errors of the checked results over their sizes, at the time of the greatest error of each "
        "quantity.",
        lambda _: draw_refinement(check),
        lambda _: bool(check.refinements),
    )
    listed = [
        *(
            picture._replace(caption=DIFFERENCE) if picture.file == "difference.png" else picture
            for picture in PICTURES
        ),
        refinement,
    ]
    return sorted(listed, key=lambda picture: not shows_others(check, picture))


def draw_refinement(check: "Check") -> Figure:
    """Draw the errors of the results of a refinement over their sizes."""
    names = check.scene.unit_names
    table = pd.DataFrame(
        {
            "case": "theirs",
            "way": f"{row.label(names)}, order {order_in_words(row.order)}",
            "method": "theirs",
            "refined": "size",
            "size": size,
            "error": error,
        }
        for row in check.refinements
        for size, error in zip(row.sizes, row.errors, strict=True)
    )
    # neither the other program nor the figure states errors of its own
    table = table.assign(tolerance=np.nan, reference=0.0, quantity="errors", when="all", outcome="")
    return draw(table, title=titled(check.scene.title, "errors against ours"))
