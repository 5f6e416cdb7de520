"""The graded quarter disc by gmsh: one background field, one thread, the same mesh every time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from .errors import MeshError
from .half_space import HalfSpaceMesh, SizeField, assemble

SYSTEM_PACKAGES = "libgl1 libglu1-mesa libxrender1 libxcursor1 libxft2 libxinerama1"


def unavailable() -> str:
    """Why gmsh cannot be used here, with the remedy; empty if it can."""
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError) as error:
        return f"gmsh cannot be loaded ({error}); on Debian or Ubuntu: apt-get install {SYSTEM_PACKAGES}"
    return ""


def mesh(field: SizeField) -> HalfSpaceMesh:
    """Mesh the quarter disc to the size field.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    with session() as gmsh:
        _geometry(gmsh, field)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, cells = gmsh.model.mesh.getElementsByType(2)
    number = np.full(int(tags.max()) + 1, -1)
    number[tags] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3)[:, :2]
    return assemble(points, number[cells].reshape(-1, 3), np.array(field.edges), "gmsh")


OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.Algorithm": 6,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeMin": 0,
}


@contextmanager
def session() -> Iterator[Any]:
    """gmsh, set up and with an empty model, which is gone at the end.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    reason = unavailable()
    if reason:
        raise MeshError(reason)
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    except Exception as error:  # gmsh raises bare exceptions
        raise MeshError(f"gmsh could not mesh the half-space: {error}") from error
    finally:
        gmsh.finalize()


def _geometry(gmsh: Any, field: SizeField) -> None:
    geometry, outer = gmsh.model.geo, field.truncation
    on_contact = [geometry.addPoint(edge, 0, 0) for edge in field.edges]
    surface_end, axis_end = geometry.addPoint(outer, 0, 0), geometry.addPoint(0, outer, 0)
    line = [*on_contact, surface_end]
    curves = [geometry.addLine(a, b) for a, b in itertools.pairwise(line)]
    curves += [geometry.addCircleArc(surface_end, on_contact[0], axis_end), geometry.addLine(axis_end, on_contact[0])]
    geometry.addPlaneSurface([geometry.addCurveLoop(curves)])
    geometry.synchronize()
    at_edges = np.array(field.ring_sizes)
    groups = [(on_contact[-1:], field.rim_size)]
    if field.centre_size < field.largest:
        groups.append((on_contact[:1], field.centre_size))
    groups += [([on_contact[1 + i] for i in np.flatnonzero(at_edges == size)], size) for size in np.unique(at_edges)]
    set_sizes(gmsh, groups, field.growth, field.largest)


def set_sizes(gmsh: Any, groups: Iterable[tuple[Iterable[int], float]], growth: float, largest: float) -> None:
    """Element sizes of the model: of each group its own at its points, growing with the distance to the largest."""
    fields = gmsh.model.mesh.field
    ramps = []
    for points, size in groups:
        distance, threshold = fields.add("Distance"), fields.add("Threshold")
        fields.setNumbers(distance, "PointsList", points)
        reach = max(largest - size, 0.0) / growth
        ramp = {"InField": distance, "DistMin": 0, "DistMax": reach, "SizeMin": size, "SizeMax": largest}
        for name, value in ramp.items():
            fields.setNumber(threshold, name, value)
        ramps.append(threshold)
    smallest = fields.add("Min")
    fields.setNumbers(smallest, "FieldsList", ramps)
    fields.setAsBackgroundMesh(smallest)
