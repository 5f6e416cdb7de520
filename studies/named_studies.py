"""The studies by their names: `ringwear.study` in Python, and what the command line needs.

The module of a study is imported only when the study is conducted.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from ..meshes import SceneError
from .crosscheck import did_you_mean, shown
from .documented import documented, function_at

if TYPE_CHECKING:
    from .crosscheck import Source
    from .study.own import Methods, Quantities
    from .study.study import Study


class NamedStudy(NamedTuple):
    """A study as it is listed.

    Parameters
    ----------
    place : module and name of its function, as in `documented`
    seconds : run time of the version for ``--quick`` on a machine of two cores, in seconds
    question : what the study does, if one function conducts several studies; it takes the name
    """

    place: str
    seconds: int
    question: str = ""

    @property
    def purpose(self) -> str:
        """What the study does, in one phrase."""
        return self.question or documented(self.place).purpose

    @property
    def options(self) -> tuple[str, ...]:
        """Names of its parameters besides the scene, `quick` and `record`."""
        names = documented(self.place).parameters
        return tuple(name for name in names if name not in ("scene", "study", "quick", "record"))


ACCURACY = "accuracy:accuracy"
STUDIES = {
    "paper": NamedStudy("paper.study:paper", 30),
    "convergence": NamedStudy(
        ACCURACY, 20, "Tell which order each quantity has, and whether it is that of theory"
    ),
    "refinement": NamedStudy(
        ACCURACY, 10, "Tell which mesh needs the fewest unknowns for an accuracy"
    ),
    "truncation": NamedStudy("truncation:truncation", 3),
    "march": NamedStudy("march:march", 2),
    "extremes": NamedStudy("extremes:extremes", 20),
    "tradeoff": NamedStudy(
        ACCURACY, 20, "Tell which method needs the fewest seconds for an accuracy"
    ),
    "operators": NamedStudy("operators:operators", 2),
}


def study(
    name: str,
    scene: "Source | None" = None,
    quick: bool = False,
    quantities: "Quantities" = None,
    methods: "Methods" = None,
    **options: Any,
) -> "Study":
    """Conduct a study of a scene: solve its levels, fit orders, draw figures, write conclusions.

    Progress is reported to the logger `ringwear`. After Ctrl-C no further level is solved, and the
    returned study contains the levels that were solved before.

    Parameters
    ----------
    name : ``"convergence"``, ``"refinement"``, ``"tradeoff"``, ``"extremes"``, ``"truncation"``,
        ``"march"``, ``"operators"`` or ``"paper"``
    scene : a Scene, the name of a bundled scene, a file, or nested dictionaries; by default
        ``"five_rings"``
    quick : whether to conduct a smaller version of the study
    quantities : names of quantities to tabulate and draw, and your own quantities: names and
        functions that take the result of a run and return a number, such as
        ``{"p at the centre": lambda result: float(result.dataset.pressure[0, 0, 0])}``
    methods : names of the methods to study, instead of the study's own selection, and methods of
        your own
    **options : further options of the study:

        meshes, degree, units
            your mesh files or scikit-fem meshes, from coarse to fine, the degree of the finite
            elements on them, and the unit of lengths in the files, if it is not that of the scene
            (`convergence`, `refinement`, `tradeoff`)
        elements
            elements of scikit-fem, by name, or your own (the same)
        steps
            time steps in the units of the scene, from coarse to fine (the same, and `march`)
        radii
            truncation radii in punch radii (`truncation`)
        key, values, or vary
            a key of the scene and its values, or values by keys (`extremes`)
        against
            abscissa of the figure: ``"size"`` (the size that the theoretical order refers to),
            ``"unknowns"`` or ``"seconds"`` (`convergence`, `refinement`, `tradeoff`)
        record
            rows so far (`Record` of `studies/study/record.py`)

    Returns
    -------
    Study
        It has `answer`, `table`, `orders`, `conclusions`, `figures`, `to_markdown()`,
        `to_latex()` and `save(folder)`.

    Raises
    ------
    SceneError
        if there is no study of that name, or if the study does not accept the scene or an option
    RingwearError
        if the reference solution of all levels cannot be computed; a single level that fails
        raises nothing and is a row of the table

    Examples
    --------
    >>> import ringwear
    >>> truncation = ringwear.study("truncation", "five_rings", quick=True)
    >>> [float(order) for order in truncation.orders["theory"]]
    [1.0, 5.0, 9.0, 13.0]
    """
    if not isinstance(name, str) or name not in STUDIES:
        hint = did_you_mean(name, STUDIES, f"give one of {', '.join(STUDIES)}", "")
        raise SceneError(f"there is no study {shown(name)}{hint}")
    listed = STUDIES[name]
    given = {"quantities": quantities, "methods": methods}
    options |= {option: value for option, value in given.items() if value is not None}
    for option in options:
        if option not in (*listed.options, "record"):
            accepted = ", ".join(listed.options) or "none but quick"
            raise SceneError(f"study {name} does not accept {option}: its options are {accepted}")
    options |= {"study": name} if listed.question else {}
    conduct = function_at(listed.place)
    # matplotlib is loaded only by those who conduct a study
    from .figures.style import in_style

    with in_style():
        result = conduct("five_rings" if scene is None else scene, quick=quick, **options)
    return replace(result, purpose=listed.purpose)
