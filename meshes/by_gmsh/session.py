"""Start and end gmsh reliably: one thread, reproducible meshes, one background size field."""

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import NamedTuple, TypeVar

import numpy as np

from ..errors import MeshError
from ..radial import Array, Indices

# a radius beyond every mesh, in punch radii
FAR_AWAY = 1e3

Meshed = TypeVar("Meshed")


def unavailable() -> str:
    """Return why gmsh cannot be used here, with the remedy; empty if it can."""
    system_packages = "libgl1 libglu1-mesa libgomp1 libxrender1 libxcursor1 libxft2 libxinerama1"
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError) as error:
        return (
            f"gmsh cannot be loaded ({error}); on Debian or Ubuntu: apt-get install "
            f"{system_packages}"
        )
    return ""


@contextmanager
def session() -> Iterator[ModuleType]:
    """Open gmsh with an empty model, and close it at the end.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    options = {
        "General.Terminal": 0,
        "General.NumThreads": 1,
        "Mesh.Algorithm": 6,
        "Mesh.MeshSizeExtendFromBoundary": 0,
        "Mesh.MeshSizeFromPoints": 0,
    }
    if reason := unavailable():
        raise MeshError(reason)
    import gmsh

    with _keeping_signal_handlers():
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for name, value in options.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    except MeshError:
        raise
    except Exception as error:  # gmsh raises bare exceptions
        raise MeshError(f"gmsh could not mesh the half-space: {error}") from error
    finally:
        gmsh.finalize()


@contextmanager
def _keeping_signal_handlers() -> Iterator[None]:
    """Keep Python's signal handlers while gmsh starts: it removes those of SIGTERM and SIGPIPE.

    Signals that arrive before they are installed again wait, except on Windows.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    ours = {
        number: handler
        for number, handler in handlers.items()
        if handler not in (None, signal.SIG_DFL)
    }
    mask = getattr(signal, "pthread_sigmask", None)
    earlier = mask(signal.SIG_BLOCK, ours) if mask else None
    try:
        yield
        for number, handler in ours.items():
            signal.signal(number, handler)
    finally:
        if mask:
            mask(signal.SIG_SETMASK, earlier)


def first_that_succeeds(generate: Callable[[float], Meshed], growths: Sequence[float]) -> Meshed:
    """Return the mesh of the first growth of the sizes, or factor on it, with which gmsh succeeds.

    It produces a degenerate element now and then, but not with a slightly smaller growth.

    Raises
    ------
    MeshError
        if gmsh fails with every growth; that of the last one
    """
    for growth in growths[:-1]:
        with suppress(MeshError):
            return generate(growth)
    return generate(growths[-1])


class Band(NamedTuple):
    """Limit the size of elements in a range of depth and radius.

    Parameters
    ----------
    top, bottom : the range of depth
    largest : greatest size of elements there
    inner, outer : range of radius in which the limit holds. If it ends before `FAR_AWAY`, sizes
        grow with the distance from the range as they do from points
    """

    top: float
    bottom: float
    largest: float
    inner: float = 0.0
    outer: float = FAR_AWAY


def set_sizes(
    gmsh: ModuleType,
    points: Indices,
    sizes: Array,
    growth: float,
    largest: float,
    bands: Sequence[Band] = (),
) -> None:
    """Set the element sizes of the model.

    Parameters
    ----------
    gmsh : the module
    points : (N, ...) numbers of points of the model
    sizes : (N,) sizes at these points
    growth : increase of the size per distance from the points
    largest : largest size
    bands : ranges of depth and radius in which the largest size is smaller
    """
    fields = gmsh.model.mesh.field
    ramps = []
    for size in np.unique(sizes):
        distance, threshold = fields.add("Distance"), fields.add("Threshold")
        fields.setNumbers(distance, "PointsList", points[sizes == size].ravel())
        reach = max(largest - size, 0.0) / growth
        ramp = {
            "InField": distance,
            "DistMin": 0,
            "DistMax": reach,
            "SizeMin": size,
            "SizeMax": largest,
        }
        for name, value in ramp.items():
            fields.setNumber(threshold, name, value)
        ramps.append(threshold)
    for band in bands:
        box = fields.add("Box")
        bounds = {"YMin": band.top, "YMax": band.bottom, "XMin": band.inner, "XMax": band.outer}
        bounds |= {"VIn": band.largest, "VOut": largest}
        if band.outer < FAR_AWAY:
            bounds["Thickness"] = max(largest - band.largest, 0.0) / growth
        for name, value in bounds.items():
            fields.setNumber(box, name, value)
        ramps.append(box)
    smallest = fields.add("Min")
    fields.setNumbers(smallest, "FieldsList", ramps)
    fields.setAsBackgroundMesh(smallest)


# gmsh's numbers of the element types
TRIANGLE = 2
QUADRILATERAL = 3


def elements(gmsh: ModuleType, kind: int) -> tuple[Array, Indices]:
    """Return the points (2, n) of the model, and the vertices (corners, m) of its elements.

    `kind` is gmsh's number of the element type.
    """
    points, number = nodes(gmsh)
    _, cells = gmsh.model.mesh.getElementsByType(kind)
    corners = number[cells].reshape(-1, {TRIANGLE: 3, QUADRILATERAL: 4}[kind])
    return np.ascontiguousarray(points.T[:2]), np.ascontiguousarray(corners.T)


def nodes(gmsh: ModuleType) -> tuple[Array, Indices]:
    """Return the points (n, 3) of the model, and their numbers, from 0, by gmsh's tags."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.full(int(tags.max(initial=0)) + 1, -1)
    number[tags] = np.arange(len(tags))
    return coordinates.reshape(-1, 3), number
