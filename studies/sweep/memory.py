"""The results of a sweep in memory, for sweeps that are not stored."""

import numpy as np
import xarray

from ...meshes import Array
from .axes import Sweep
from .template import block_sizes, identity, one_scene, regions, template


class InMemory:
    """The results of a sweep in memory, with the methods of `store.Store`.

    Parameters
    ----------
    sweep : sweep whose results are collected

    Attributes
    ----------
    blank : empty results of one scene
    """

    def __init__(self, sweep: Sweep) -> None:
        empty = template(sweep)
        self.blank = one_scene(sweep, empty)
        self._sweep, self._regions = sweep, regions(sweep, block_sizes(sweep, empty))
        # the arrays of the template are views without memory
        filled = {
            name: variable.copy(data=np.array(variable.values))
            for name, variable in empty.data_vars.items()
        }
        self._dataset = empty.assign(filled).assign_attrs(identity(sweep))

    def unfinished(self, retry_failed: bool = False) -> dict[int, Sweep]:
        """Return all blocks, each as a sweep, by number."""
        return {number: self._sweep.part(region) for number, region in enumerate(self._regions)}

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Keep the results of a block."""
        place = tuple(self._regions[number].values())
        for name, array in values.items():
            self._dataset[name].values[place] = array

    def dataset(self) -> xarray.Dataset:
        """Return the results."""
        return self._dataset
