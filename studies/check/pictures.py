"""List the figures of a check: those of a run, and the errors of a refinement over its sizes."""

from matplotlib.figure import Figure

from ..figures.catalogue import PICTURES
from ..figures.style import Picture
from ..problem.unit_names import UnitNames
from ..study.errors_over_size import draw_errors
from .checked import CheckedOutcome
from .refinement import order_in_words

# caption of the figure of the difference in a check, in place of that of a run
DIFFERENCE = (
    "The checked results minus ours: pressure, worn profile and displacement along the radius, "
    "relative to the norms of ours, with our error estimate as a band; and the same differences "
    "over radius and time, with the largest one marked."
)


def draw_refinement(result: CheckedOutcome) -> Figure:
    """Draw the errors of the results of a refinement over their sizes."""
    names = UnitNames.of(result.scene.units)
    curves = {
        f"{row.label(names)}, order {order_in_words(row.sequence.order)}": row.sequence
        for row in result.refinements
    }
    return draw_errors({"size": curves}, "error, relative to ours", result.scene.title)


CHECK_PICTURES = (
    *(
        picture._replace(caption=DIFFERENCE) if picture.file == "difference.png" else picture
        for picture in PICTURES
    ),
    Picture(
        "refinement.png",
        "Errors of the checked results over their sizes, at the time of the greatest error of each "
        "quantity.",
        draw_refinement,
        lambda result: bool(result.refinements),
    ),
)
