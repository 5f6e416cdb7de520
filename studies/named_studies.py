"""The studies by their names: `ringwear.study` in Python, and what the command line needs.

The module of a study is imported only when the study is conducted.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from .crosscheck import SceneError, Source
from .crosscheck.problem.written import shown
from .crosscheck.scene.calls import naming_arguments
from .crosscheck.scene.explain import nearest

if TYPE_CHECKING:
    from .study.own import Methods, Quantities
    from .study.study import Study


@dataclass(frozen=True)
class NamedStudy:
    """A study as it is listed.

    Parameters
    ----------
    load : imports the module of the study, and returns its function
    purpose : subject of the study, in one phrase
    seconds : run time of the version for ``--quick`` on a machine of two cores, in seconds
    options : names of its options besides the scene, `quick` and `record`
    scene : name of the default scene
    """

    load: "Callable[[], Callable[..., Study]]"
    purpose: str
    seconds: int
    options: tuple[str, ...] = ()
    scene: str = "five_rings"


def _paper() -> "Callable[..., Study]":
    from .paper.study import paper

    return paper


def _convergence() -> "Callable[..., Study]":
    from .convergence import convergence

    return convergence


def _refinement() -> "Callable[..., Study]":
    from .refinement import refinement

    return refinement


def _elements() -> "Callable[..., Study]":
    from .elements import elements

    return elements


def _truncation() -> "Callable[..., Study]":
    from .truncation import truncation

    return truncation


def _march() -> "Callable[..., Study]":
    from .march import march

    return march


def _extremes() -> "Callable[..., Study]":
    from .extremes import extremes

    return extremes


def _tradeoff() -> "Callable[..., Study]":
    from .tradeoff import tradeoff

    return tradeoff


STUDIES: dict[str, NamedStudy] = {
    "paper": NamedStudy(
        _paper,
        "the whole paper: Figs. 4 to 7 redrawn, its claims checked, and its open questions",
        30,
    ),
    "convergence": NamedStudy(
        _convergence,
        "orders of convergence of every quantity in element size and degree, compared with theory",
        20,
        ("methods", "meshes", "degree", "elements", "steps", "quantities", "against"),
    ),
    "refinement": NamedStudy(
        _refinement,
        "cost of accuracy on uniform, graded, adaptive, layered and your own meshes",
        10,
        ("meshes", "degree", "methods", "quantities"),
    ),
    "elements": NamedStudy(
        _elements,
        "stable pairs of displacement and pressure spaces: elements of scikit-fem, or your own",
        7,
        ("elements",),
    ),
    "truncation": NamedStudy(
        _truncation,
        "errors due to the outer boundary, for every far field and Poisson's ratio",
        3,
        ("radii",),
    ),
    "march": NamedStudy(
        _march,
        "which time step a history needs, and the stability limit of explicit steps",
        2,
        ("steps", "quantities"),
    ),
    "extremes": NamedStudy(
        _extremes,
        "extreme values of any key of a scene: true and stated errors, and those of a naive solver",
        20,
        ("key", "values", "vary", "methods", "quantities"),
    ),
    "tradeoff": NamedStudy(
        _tradeoff,
        "speed against accuracy: tolerance, error estimate and true error of each method and march",
        20,
        ("methods", "quantities"),
    ),
}


@naming_arguments
def study(
    name: str,
    scene: Source | None = None,
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
    name : ``"convergence"``, ``"refinement"``, ``"elements"``, ``"extremes"``, ``"tradeoff"``,
        ``"truncation"``, ``"march"`` or ``"paper"``
    scene : a Scene, the name of a bundled scene, a file, or nested dictionaries; by default the
        study's own scene
    quick : whether to conduct a smaller version of the study
    quantities : names of quantities to tabulate and draw, and your own quantities: names and
        functions that take the result of a run and return a number, such as
        ``{"p at the centre": lambda result: float(result.dataset.pressure[0, 0, 0])}``
    methods : names of the methods to study, instead of the study's own selection, and methods of
        your own
    **options : further options of the study:

        meshes, degree
            your mesh files or scikit-fem meshes, from coarse to fine, and the degree of the
            finite elements on them (`convergence`, `refinement`)
        elements
            elements of scikit-fem, by name, or your own (`convergence`, `elements`)
        steps
            time steps in the units of the scene, from coarse to fine (`convergence`, `march`)
        radii
            truncation radii in punch radii (`truncation`)
        key, values, or vary
            a key of the scene and its values, or values by keys (`extremes`)
        against
            abscissa of the figures: ``"size"`` (the size that the theoretical order refers to),
            ``"unknowns"`` or ``"seconds"`` (`convergence`)
        record
            rows so far (`Record` of `studies/study/record.py`)

    Returns
    -------
    Study
        It has `table`, `orders`, `conclusions`, `figures`, `to_markdown()`, `to_latex()` and
        `save(folder)`.

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
    >>> [float(order) for order in truncation.orders["expected"]]
    [1.0, 5.0, 9.0, 13.0]
    """
    if not isinstance(name, str) or name not in STUDIES:
        similar = nearest(str(name), STUDIES)
        hint = f"did you mean {similar}? Otherwise " if similar else ""
        raise SceneError(f"there is no study {shown(name)}: {hint}give one of {', '.join(STUDIES)}")
    listed = STUDIES[name]
    given = {"quantities": quantities, "methods": methods}
    options |= {option: value for option, value in given.items() if value is not None}
    for option in options:
        if option not in (*listed.options, "record"):
            accepted = ", ".join(listed.options) or "none but quick"
            raise SceneError(f"study {name} does not accept {option}: its options are {accepted}")
    conduct = listed.load()
    # matplotlib is loaded only by those who conduct a study
    from .figures.style import in_style

    with in_style():
        result = conduct(listed.scene if scene is None else scene, quick=quick, **options)
    return replace(result, purpose=listed.purpose)
