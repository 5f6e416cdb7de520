"""Load objects of the user named on the command line: functions of a result, and elements."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING

from ..crosscheck import SceneError

if TYPE_CHECKING:
    from skfem import Element

    from .options import Quantity

FORM = "FILE.py:NAME"
"""How the command line names an object: a Python file, and the name of the object in it."""


def load_quantity(text: str) -> "tuple[str, Quantity]":
    """Load a quantity from ``FILE.py:NAME``; return its name and its function.

    Raises
    ------
    SceneError
        if there is no such file, or if the file does not define such a function
    """
    value = _load("--quantity", text)
    if not callable(value):
        raise SceneError(
            f"--quantity {text}: is not a function of a result: give {FORM} of a function"
        )
    return text.rpartition(":")[2], value


def load_element(text: str) -> "Element":
    """Return an element of scikit-fem by its name, or one of the user from ``FILE.py:NAME``.

    Raises
    ------
    SceneError
        if scikit-fem has no element of that name, or if the file does not define an element
    """
    import skfem

    value = _load("--element", text) if ".py:" in text else getattr(skfem, text, None)
    element = value() if isinstance(value, type) else value
    if not isinstance(element, skfem.Element):
        raise SceneError(
            f"--element {text}: is not an element: give the name of an element of scikit-fem, such "
            f"as ElementTriP2, or {FORM} of an element"
        )
    return element


def _load(option: str, text: str) -> object:
    """Run a Python file and return the object with a given name from it.

    Raises
    ------
    SceneError
        if the text is not FILE.py:NAME, if the file cannot be run, or if it does not define NAME
    """
    file, colon, name = text.rpartition(":")
    if not colon or not Path(file).is_file():
        raise SceneError(f"{option} {text}: give {FORM}, a Python file and a name defined in it")
    spec = spec_from_file_location(Path(file).stem, file)
    if spec is None or spec.loader is None:
        raise SceneError(f"{option} {text}: {file} is not a Python file")
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise SceneError(f"{option} {text}: {file} fails: {error}") from error
    if not hasattr(module, name):
        raise SceneError(f"{option} {text}: {file} has no {name}")
    return getattr(module, name)
