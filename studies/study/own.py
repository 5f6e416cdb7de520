"""Read what a user brings to a study: the scene, options, meshes, elements, quantities, methods.

What does not fit the study is refused with the remedy.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from runpy import run_path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...meshes import MeshError, SceneError
from ..crosscheck import (
    METHODS,
    Method,
    Problem,
    Scene,
    Source,
    check_one_line,
    did_you_mean,
    numbers,
    shown,
)

if TYPE_CHECKING:
    from skfem import Element, Mesh

Quantity: TypeAlias = Callable[..., float]
"""A function that takes the result of a run and returns a number."""
Named: TypeAlias = Mapping[str, Quantity]
"""Functions of a result that the user defines, by the names of their quantities."""
Quantities: TypeAlias = "Mapping[str, Quantity] | Iterable[str | Quantity] | str | Quantity | None"
"""Names of quantities, and functions of a result, which may have names of their own."""
Methods: TypeAlias = "Iterable[str | Method] | str | Method | None"
"""Names of methods, and methods of the user."""
OF_ANY_PUNCH = "convergence, extremes and tradeoff"
OF_LAYERS = "extremes, tradeoff and truncation"
"""Names of the studies that accept any punch, and layers."""
DEFAULT_TIMES = (0.0, 0.01, 0.1, 1.0)
"""Times of scenes without any, in a / (E* k_max v0)."""
FORM = "FILE.py:NAME"
"""How the command line names an object: a Python file, and the name of the object in it."""


def accept(name: str, source: Source, any_punch: bool = False, layered: bool = False) -> Scene:
    """Return the scene of a study, if the study accepts it.

    Parameters
    ----------
    name : name of the study
    source : a scene, a file, the name of a bundled scene, or nested dictionaries
    any_punch : whether the study accepts any punch, not only flat punches under a force
    layered : whether it accepts a layered half-space

    Raises
    ------
    SceneError
        if it does not; the message names the studies that do
    """
    scene = Scene.of(source)
    problem = scene.problem
    if not (any_punch or (problem.full_contact and problem.indentation is None)):
        raise SceneError(
            f"study {name} accepts only flat punches under a force, whose contact edges are fixed: "
            "leave out punch.recess and punch.profile, and give load.normal_force; the "
            f"studies {OF_ANY_PUNCH} accept any punch"
        )
    if problem.ground.layered and not layered:
        raise SceneError(
            f"study {name} accepts only a homogeneous half-space: leave out half_space.layers; "
            f"studies {OF_LAYERS} accept them"
        )
    return scene


def steps_of(scene: Scene, steps: object) -> list[float]:
    """Return time steps of a user without units, exactly as given.

    Raises
    ------
    SceneError
        if the scene has no history or a load that varies, if something is not a number, or if a
        step is not positive or longer than the last time
    """
    given = numbers("steps", steps)
    if given and (not scene.problem.earliest or scene.problem.loading.varies):
        raise SceneError(
            "--steps: a march in equal steps needs a scene with wear.times under a constant load"
        )
    longest = max(scene.wear.times, default=0.0)
    for step in given:
        if not 0 < step <= longest:
            raise SceneError(f"--steps {step:g}: give steps above 0, up to {longest:.3g}")
    return [step / scene.problem.units.time for step in given]


def with_times(scene: Scene) -> Scene:
    """Return a scene with times of wear: its own, or `DEFAULT_TIMES` if it has none."""
    if scene.problem.earliest:
        return scene
    times = [time * scene.problem.units.time for time in DEFAULT_TIMES]
    return scene.changed({"wear.times": times})


def read_quantities(
    given: Quantities, known: Iterable[str]
) -> tuple[tuple[str, ...], dict[str, Quantity]]:
    """Return the names of known quantities, and the functions of the user by their names.

    Parameters
    ----------
    given : names of quantities, ``FILE.py:NAME`` of functions, or functions of a result
    known : names of the quantities that a study can tabulate

    Raises
    ------
    SceneError
        if one of them is neither; the message names it
    """
    names, functions = list[str](), dict[str, Quantity]()
    if isinstance(given, Mapping):
        functions |= given
        given = ()
    entries = [given] if isinstance(given, str) or callable(given) else list(given or ())
    for entry in entries:
        if isinstance(entry, str) and ".py:" in entry:
            function = _load("--quantity", entry, Callable, "a function of a result")
            functions[entry.rpartition(":")[2]] = function
        elif callable(entry) and hasattr(entry, "__name__"):
            functions[entry.__name__] = entry
        elif isinstance(entry, str) and entry in known:
            names.append(entry)
        else:
            otherwise = (
                "give functions of the result of a run, {'mean p': lambda result: "
                "float(result.dataset.pressure.mean())}, or names of " + ", ".join(known)
            )
            hint = did_you_mean(entry, known if isinstance(entry, str) else (), otherwise, "")
            raise SceneError(f"quantities = {shown(entry)}{hint}")
    try:
        return tuple(names), {check_one_line(name): each for name, each in functions.items()}
    except ValueError as error:
        raise SceneError(f"the name of a quantity: {error}") from None


def read_methods(
    given: Methods, known: Sequence[str], study: str
) -> tuple[tuple[str, ...], tuple[Method, ...]]:
    """Return the names of methods that a study has levels for, and the methods of the user.

    Parameters
    ----------
    given : names, ``FILE.py:NAME`` of a method, or methods; None or empty for all known ones
    known : names of the methods that the study has levels for
    study : name of the study, for messages

    Raises
    ------
    SceneError
        if one of them is none of these; the message names those that are known
    """
    if not given:
        return tuple(known), ()
    names, own = list[str](), list[Method]()
    for entry in load_methods(given):
        if isinstance(entry, Method):
            try:
                check_one_line(entry.name)
            except ValueError as error:
                raise SceneError(f"the name of a method or a program: {error}") from None
            own.append(entry)
        elif isinstance(entry, str) and entry in known:
            names.append(entry)
        else:
            unlisted = isinstance(entry, str) and entry in METHODS
            reason = "it has no sequence of levels" if unlisted else "it is not a method"
            raise SceneError(
                f"methods: study {study} has no {shown(entry)}, because {reason}: give some of "
                f"{', '.join(known)}, or methods of your own"
            )
    return tuple(names), tuple(own)


def load_methods(given: Methods) -> list[str | Method]:
    """Return names of methods, and methods; those given as ``FILE.py:NAME`` are loaded.

    Raises
    ------
    SceneError
        if a file does not define such a method
    """
    methods = list[str | Method]()
    for entry in [given] if isinstance(given, str | Method) else given or ():
        if isinstance(entry, str) and ".py:" in entry:
            entry = _load("--methods", entry, Method, "a method")
        methods.append(entry)
    return methods


ELEMENTS = {
    "P1": "ElementTriP1",
    "P2": "ElementTriP2",
    "Q1": "ElementQuad1",
    "Q2": "ElementQuad2",
    "Q2S": "ElementQuadS2",
}
"""Names of scikit-fem's elements by those that papers use: on triangles (P) and quadrilaterals (Q),
of degree 1 or 2; Q2S has eight nodes."""


def element_named(name: str) -> str:
    """Return the name of an element in upper case.

    Raises
    ------
    SceneError
        if there is no such element
    """
    if str(name).upper() not in ELEMENTS:
        hint = did_you_mean(str(name), ELEMENTS, f"give one of {', '.join(ELEMENTS)}")
        raise SceneError(f"element = {shown(name)}{hint}")
    return str(name).upper()


def read_elements(given: "Iterable[str | Element] | str | Element") -> "tuple[Element, ...]":
    """Return elements: those of scikit-fem that are given by name, and the user's own.

    Raises
    ------
    SceneError
        if one of them is no element
    """
    entries = list(given) if isinstance(given, list | tuple) else [given]
    return tuple(load_element(each) if isinstance(each, str) else each for each in entries)


def load_element(text: str) -> "Element":
    """Return an element by its short name, such as P2, its name in scikit-fem, or from a file.

    The form ``FILE.py:NAME`` is that of an element of the user.

    Raises
    ------
    SceneError
        if scikit-fem has no element of that name, or if the file does not define an element
    """
    import skfem

    if ".py:" in text:
        return _load("--element", text, skfem.Element, "an element")
    element = getattr(skfem, ELEMENTS.get(text.upper(), text), None)
    if not (isinstance(element, type) and issubclass(element, skfem.Element)):
        raise SceneError(
            f"--element {text}: is not an element: give one of {', '.join(ELEMENTS)}, the name "
            f"of an element of scikit-fem, such as ElementTriP3, or {FORM} of an element"
        )
    return element()


def degree_of(element: "Element") -> int:
    """Return the polynomial degree of an element along a side.

    Raises
    ------
    SceneError
        if the element is not continuous, or does not have one function for each vertex
    """
    from skfem import ElementH1

    if not isinstance(element, ElementH1) or element.nodal_dofs != 1:
        raise SceneError(
            f"--element {element_name(element)}: the displacement has to be continuous, with one "
            "function for each vertex: give an element such as ElementTriP2 or ElementQuad2"
        )
    return 1 + int(element.facet_dofs)


def element_name(element: "Element") -> str:
    """Return the name of an element's class, without the prefix "Element"."""
    return type(element).__name__.removeprefix("Element")


def length_of(scene: Scene, units: str | float) -> float:
    """Return the size of the lengths of a file in the lengths of a scene.

    Parameters
    ----------
    scene : the scene
    units : unit of the lengths of the file, alone or as the first of several; a factor on them; or
        empty if they are those of the scene

    Raises
    ------
    SceneError
        if it is no unit of length, or if the numbers of the scene have none
    """
    text = str(units).strip()
    if not text:
        return 1.0
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if factor > 0:
        return factor
    if scene.unit_names.base is None:
        raise SceneError(
            f"--units {text}: the numbers of the scene have no units: give a factor on the lengths "
            "of the file, such as 0.1"
        )
    return scene.unit_names.size_of(text.partition(",")[0].strip(), "length", "--units")


def read_meshes(
    problem: Problem, given: "Sequence[str | Path | Mesh] | str | Path | Mesh", size: float = 1.0
) -> "dict[str, Mesh]":
    """Return meshes of the user in punch radii, with their boundaries named, by the names of files.

    A file is in the units of the scene, times `size`, a mesh of scikit-fem in punch radii. Meshes
    that are not from files are `mesh 1`, `mesh 2`, ... If several files have the same name, it is
    the path, followed by the number in parentheses.

    Raises
    ------
    SceneError
        if one of them is no mesh of the scene's half-space
    """
    from skfem import Mesh

    from ...meshes import as_half_space, files

    sources: list[Any] = list(given) if isinstance(given, list | tuple) else [given]
    meshes, edges = list[Mesh](), problem.merged.ring_edges
    for source in sources:
        is_file = isinstance(source, str | Path)
        if not (is_file or isinstance(source, Mesh)):
            raise SceneError(
                f"meshes has {shown(source)}: give mesh files, from coarse to fine, or meshes of "
                "scikit-fem"
            )
        try:
            if is_file:
                meshes.append(files.read(source, edges, problem.units.length / size))
            else:
                meshes.append(as_half_space(source, edges))
        except MeshError as error:
            raise SceneError(f"--mesh {error}") from error
    names = [
        Path(source).name if isinstance(source, str | Path) else f"mesh {number}"
        for number, source in enumerate(sources, 1)
    ]
    listed = enumerate(zip(names, sources, meshes, strict=True), 1)
    return {
        name if names.count(name) == 1 else f"{source} ({number})": mesh
        for number, (name, source, mesh) in listed
    }


def _load(option: str, text: str, kind: Any, what: str) -> Any:
    """Run a Python file and return the object with a given name from it, or an instance of a class.

    Parameters
    ----------
    option : of the command line
    text : file and name, as in `FORM`
    kind, what : the type that the object must have, and what it is called

    Raises
    ------
    SceneError
        if the text is not FILE.py:NAME, if the file cannot be run, or if it does not define such an
        object
    """
    file, _, name = text.rpartition(":")
    if not Path(file).is_file():
        raise SceneError(f"{option} {text}: give {FORM}, a Python file and a name defined in it")
    try:
        names = run_path(file)
    except Exception as error:
        raise SceneError(f"{option} {text}: {file} fails: {error}") from error
    if name not in names:
        raise SceneError(f"{option} {text}: {file} has no {name}")
    found = names[name]() if isinstance(names[name], type) else names[name]
    if not isinstance(found, kind):
        raise SceneError(f"{option} {text}: is not {what}: give {FORM} of {what}")
    return found
