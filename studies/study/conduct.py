"""The call of a study, by name: `ringwear.study`, and what the command line calls."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...meshes.errors import SceneError
from ..calls import naming_arguments
from ..figures.style import in_style
from ..scene.explain import nearest
from ..scene.scene import Scene, Source
from .levels import Record
from .listing import STUDIES
from .options import ABSCISSAS, Options, Quantity
from .study import Study

if TYPE_CHECKING:
    from skfem import Element, Mesh


@naming_arguments
def study(
    name: str,
    scene: Source | None = None,
    quick: bool = False,
    quantities: "Mapping[str, Quantity] | Sequence[Quantity] | None" = None,
    methods: Sequence[str] | str | None = None,
    meshes: "Sequence[str | Mesh]" = (),
    degree: int | None = None,
    elements: "Sequence[Element]" = (),
    steps: Sequence[float] = (),
    against: str = "size",
) -> Study:
    """Conduct a study of a scene: solve its levels, fit orders, draw figures, and conclude.

    Progress goes to the logger `ringwear`. Ctrl-C ends the levels, and the study holds those that
    were solved.

    Parameters
    ----------
    name : ``"convergence"``, ``"refinement"``, ``"elements"``, ``"extremes"``, ``"tradeoff"``,
        ``"truncation"``, ``"march"`` or ``"paper"``
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries; by default the
        study's own
    quick : whether a smaller version will do
    quantities : numbers of one's own, functions of the result of a run, by what they are called:
        ``{"p at the centre": lambda result: float(result.dataset.pressure[0, 0, 0])}``
    methods : names of methods, in place of those that the study compares
    meshes : mesh files or scikit-fem meshes of one's own, from coarse to fine
    degree : of the finite elements on `meshes`
    elements : elements of scikit-fem, in place of those that the study compares
    steps : in time, in the units of the scene, from coarse to fine
    against : what figures draw errors against: ``"size"``, that of theory, ``"unknowns"`` or
        ``"seconds"``

    Returns
    -------
    study : with `table`, `orders`, `conclusions`, `figures`, `to_markdown()`, `to_latex()` and
        `save(folder)`

    Raises
    ------
    SceneError
        if there is no study of that name, or if it does not go with the scene or an option
    RingwearError
        if what all levels need cannot be computed; a level that fails is a row of the table

    Examples
    --------
    >>> import ringwear
    >>> found = ringwear.study("truncation", "five_rings", quick=True)
    >>> [float(order) for order in found.orders["expected order"]]
    [1.0, 5.0, 9.0, 13.0]
    """
    if name not in STUDIES:
        near = nearest(str(name), STUDIES)
        meant = f"did you mean {near}? Else " if near else ""
        raise SceneError(f"there is no study {name!r}: {meant}give one of {', '.join(STUDIES)}")
    if quantities is not None and not isinstance(quantities, Mapping):
        quantities = {function.__name__: function for function in quantities}
    options = Options(
        quick,
        dict(quantities or {}),
        (methods,) if isinstance(methods, str) else tuple(methods or ()),
        tuple(meshes),
        degree,
        tuple(elements),
        tuple(steps),
        against,
    )
    return conduct(name, Scene.of(STUDIES[name].scene if scene is None else scene), options)


def conduct(name: str, scene: Scene, options: Options, record: Record | None = None) -> Study:
    """Conduct a study of a scene, and record its rows as they come.

    Raises
    ------
    SceneError
        if the study does not go with the scene or an option
    """
    refuse_what_does_not_fit(name, scene, options)
    with in_style():
        found = STUDIES[name].conduct(scene, options, record or Record())
    return replace(found, purpose=STUDIES[name].purpose)


def refuse_what_does_not_fit(name: str, scene: Scene, options: Options) -> None:
    """Raise if a study does not know the punch of a scene, or what to do with an option.

    Raises
    ------
    SceneError
        which names the studies that do, or the options that the study takes
    """
    listed, problem = STUDIES[name], scene.problem
    flat = problem.full_contact and problem.indentation is None
    if not (listed.of_any_punch or flat):
        raise SceneError(
            f"study {name} is about flat punches under a force, whose edges stay: leave out "
            "punch.recess and punch.profile, and give load.normal_force; studies "
            f"{_those_that('of_any_punch')} take any punch"
        )
    if problem.merged.linear and not listed.along_radius:
        raise SceneError(
            f"study {name} is about rings, each with one wear coefficient: give "
            "punch.wear_coefficients in place of punch.wear_coefficient along the radius; studies "
            f"{_those_that('along_radius')} take it"
        )
    if problem.ground is not None and not listed.of_layers:
        knowing = " and ".join(name for name, study in STUDIES.items() if study.of_layers)
        raise SceneError(
            f"study {name} is about a homogeneous half-space: leave out half_space.layers; "
            f"studies {knowing} take them"
        )
    for option in options.given:
        if option not in listed.takes:
            which = ", ".join(listed.takes) or "none but quick"
            raise SceneError(f"study {name} does not take {option}: its options are {which}")
    if options.against not in ABSCISSAS:
        raise SceneError(
            f"against = {options.against!r} is no abscissa: give one of {', '.join(ABSCISSAS)}"
        )


def _those_that(trait: str) -> str:
    """Return the names of the studies with a trait of `ListedStudy`, as a list in words."""
    *names, last = (name for name, listed in STUDIES.items() if getattr(listed, trait))
    return f"{', '.join(names)} and {last}"
