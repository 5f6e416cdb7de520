"""Objects of the user's own that the command line names: functions of a result, and elements."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING

from ...meshes.errors import SceneError

if TYPE_CHECKING:
    from skfem import Element

    from .options import Quantity

FORM = "FILE.py:NAME"


def load_quantity(text: str) -> "tuple[str, Quantity]":
    """Return the name and the function of a quantity that ``FILE.py:NAME`` names.

    Raises
    ------
    SceneError
        if there is no such file, or no such function in it
    """
    value = _load("--quantity", text)
    if not callable(value):
        raise SceneError(f"--quantity {text}: is no function of a result: give {FORM} of one")
    return text.rpartition(":")[2], value


def load_element(text: str) -> "Element":
    """Return an element: scikit-fem's by its name, or one of the user's by ``FILE.py:NAME``.

    Raises
    ------
    SceneError
        if scikit-fem has no element of that name, or the file has none
    """
    import skfem

    value = _load("--element", text) if ".py:" in text else getattr(skfem, text, None)
    element = value() if isinstance(value, type) else value
    if not isinstance(element, skfem.Element):
        raise SceneError(
            f"--element {text}: is no element: give a name of scikit-fem's, such as ElementTriP2, "
            f"or {FORM} of an element"
        )
    return element


def _load(option: str, text: str) -> object:
    """Return the object of a name in a Python file, which is run.

    Raises
    ------
    SceneError
        if the text is not FILE.py:NAME, or if the file cannot be run or lacks the name
    """
    file, colon, name = text.rpartition(":")
    if not colon or not Path(file).is_file():
        raise SceneError(f"{option} {text}: give {FORM}, a Python file and a name in it")
    spec = spec_from_file_location(Path(file).stem, file)
    if spec is None or spec.loader is None:
        raise SceneError(f"{option} {text}: {file} is no Python file")
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise SceneError(f"{option} {text}: {file} fails: {error}") from error
    if not hasattr(module, name):
        raise SceneError(f"{option} {text}: {file} has no {name}")
    return getattr(module, name)
