"""Named arrays with dimensions and attributes, of which all results consist."""

from typing import NamedTuple

from ....meshes.radial import Array

Labelled = dict[str, tuple[tuple[str, ...], Array, dict[str, str]]]


class Table(NamedTuple):
    """Arguments of `xarray.Dataset`: dimensions, values and attributes of each array, by its name.

    Most runs need no xarray, whose import takes as long as some runs.
    """

    variables: Labelled
    coordinates: Labelled
    attributes: dict[str, str]
