"""Call a study by its name: `ringwear.study` in Python, and `conduct` for the command line."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..crosscheck import Scene, SceneError, Source
from ..crosscheck.problem.written import check_one_line, shown
from ..crosscheck.scene.calls import naming_arguments
from ..crosscheck.scene.explain import nearest
from ..crosscheck.scene.keys import numbers
from ..figures.style import in_style
from .levels import Record
from .listing import STUDIES
from .options import ABSCISSAS, Options, Quantity
from .own_objects import load_element
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
    quantities : your own quantities: names and functions that take the result of a run and return a
        number, such as
        ``{"p at the centre": lambda result: float(result.dataset.pressure[0, 0, 0])}``
    methods : names of the methods to study, instead of the study's own selection
    meshes : your mesh files or scikit-fem meshes, from coarse to fine
    degree : polynomial degree of the finite elements on `meshes`
    elements : elements of scikit-fem to study, instead of the study's own selection
    steps : time steps in the units of the scene, from coarse to fine
    against : abscissa of the figures of errors: ``"size"`` (the size that the theoretical order
        refers to), ``"unknowns"`` or ``"seconds"``

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
    >>> [float(order) for order in truncation.orders["expected order"]]
    [1.0, 5.0, 9.0, 13.0]
    """
    if not isinstance(name, str) or name not in STUDIES:
        similar = nearest(str(name), STUDIES)
        hint = f"did you mean {similar}? Otherwise " if similar else ""
        raise SceneError(f"there is no study {shown(name)}: {hint}give one of {', '.join(STUDIES)}")
    if quantities is not None and not isinstance(quantities, Mapping):
        if callable(quantities):
            quantities = [quantities]
        wrong = [each for each in quantities if not hasattr(each, "__name__")]
        if isinstance(quantities, str) or wrong:
            raise SceneError(
                f"quantities = {shown(quantities)}: give functions of the result of a run, "
                "{'mean p': lambda result: float(result.dataset.pressure.mean())}"
            )
        quantities = {function.__name__: function for function in quantities}
    try:
        quantities = {check_one_line(name): each for name, each in (quantities or {}).items()}
    except ValueError as error:
        raise SceneError(f"the name of a quantity: {error}") from None
    options = Options(
        quick,
        quantities,
        (methods,) if isinstance(methods, str) else tuple(methods or ()),
        tuple(_meshes(meshes)),
        degree,
        tuple(load_element(each) if isinstance(each, str) else each for each in _several(elements)),
        tuple(numbers("steps", steps)),
        against,
    )
    return conduct(name, Scene.of(STUDIES[name].scene if scene is None else scene), options)


def _several(values: object) -> "list[Any]":
    """Return values as a list; a single one, such as a text, is a list of one."""
    return list(values) if isinstance(values, list | tuple) else [values]


def _meshes(meshes: "Sequence[str | Mesh] | str | Mesh") -> "list[str | Mesh]":
    """Return the files and meshes of a user as a list.

    Raises
    ------
    SceneError
        if one of them is neither
    """
    for mesh in _several(meshes):
        if not (isinstance(mesh, str | Path) or hasattr(mesh, "p")):
            raise SceneError(
                f"meshes has {shown(mesh)}: give mesh files, from coarse to fine, or meshes of "
                "scikit-fem"
            )
    return _several(meshes)


def conduct(name: str, scene: Scene, options: Options, record: Record | None = None) -> Study:
    """Conduct a study of a scene, and write the row of each level as soon as it is solved.

    Raises
    ------
    SceneError
        if the study does not accept the scene or an option
    """
    refuse_what_does_not_fit(name, scene, options)
    with in_style():
        result = STUDIES[name].conduct(scene, options, record or Record())
    return replace(result, purpose=STUDIES[name].purpose)


def refuse_what_does_not_fit(name: str, scene: Scene, options: Options) -> None:
    """Raise an error if a study does not accept the punch of a scene or one of the options.

    Raises
    ------
    SceneError
        its message names the studies that accept this punch, or the options that the study accepts
    """
    listed, problem = STUDIES[name], scene.problem
    flat = problem.full_contact and problem.indentation is None
    if not (listed.any_punch or flat):
        raise SceneError(
            f"study {name} accepts only flat punches under a force, whose contact edges are fixed: "
            "leave out punch.recess and punch.profile, and give load.normal_force; the "
            f"studies {_studies_with('any_punch')} accept any punch"
        )
    if problem.merged.linear and not listed.radial_wear:
        raise SceneError(
            f"study {name} accepts only rings, each with one wear coefficient: give "
            "punch.wear_coefficients instead of punch.wear_coefficient along the radius; the "
            f"studies {_studies_with('radial_wear')} accept it"
        )
    if problem.ground.layered and not listed.layered:
        accepting = " and ".join(name for name, study in STUDIES.items() if study.layered)
        raise SceneError(
            f"study {name} accepts only a homogeneous half-space: leave out half_space.layers; "
            f"studies {accepting} accept them"
        )
    for option in options.changed:
        if option not in listed.option_names:
            accepted = ", ".join(listed.option_names) or "none but quick"
            raise SceneError(f"study {name} does not accept {option}: its options are {accepted}")
    if options.degree is not None and not options.meshes:
        raise SceneError(
            "degree is that of the finite elements on meshes of your own: give --mesh FILE, in "
            "Python meshes=[...], or leave it out"
        )
    if options.against not in ABSCISSAS:
        raise SceneError(
            f"against = {shown(options.against)} is not an abscissa of the figures: give one of "
            f"{', '.join(ABSCISSAS)}"
        )


def _studies_with(flag: str) -> str:
    """Return the names of the studies for which a flag of `ListedStudy` is set, as "a, b and c"."""
    *names, last = (name for name, listed in STUDIES.items() if getattr(listed, flag))
    return f"{', '.join(names)} and {last}"
