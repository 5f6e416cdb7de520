"""The table of results as arrays over named dimensions, and as a netCDF file."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray


class Variable(NamedTuple):
    """Dimensions, values and attributes of an array."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[str, str]


@dataclass(frozen=True, eq=False)
class Table:
    """Arrays over named dimensions, with the names that they have in a Dataset of xarray.

    Parameters
    ----------
    data_vars, coords : variables and coordinates by name
    attrs : attributes of the whole table
    """

    data_vars: Mapping[str, Variable]
    coords: Mapping[str, Variable]
    attrs: dict[str, str]

    @property
    def variables(self) -> dict[str, Variable]:
        """Variables and coordinates by name."""
        return {**self.data_vars, **self.coords}

    def equals(self, other: "Table") -> bool:
        """Return whether another table has the same arrays with the same attributes."""
        mine, theirs = self.variables, other.variables
        return (
            self.attrs == other.attrs
            and mine.keys() == theirs.keys()
            and all(
                array.dims == theirs[name].dims
                and array.attrs == theirs[name].attrs
                and np.array_equal(
                    array.values, theirs[name].values, array.values.dtype.kind == "f"
                )
                for name, array in mine.items()
            )
        )

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """The table as a Dataset, with the same arrays.

        It is made when it is asked for: xarray takes as long to load as a small run.
        """
        import pandas
        import xarray
        from xarray.indexes import PandasIndex

        # the arrays are known to be plain; to find that out, xarray would load every installed
        # library that has arrays of its own
        plain = {
            name: xarray.Variable(*array, fastpath=True) for name, array in self.variables.items()
        }
        indexes = {
            name: PandasIndex(pandas.Index(each.values), name, coord_dtype=each.dtype)
            for name, each in plain.items()
            if each.dims == (name,)
        }
        for name, index in indexes.items():
            plain |= index.create_variables({name: plain[name]})
        coords = xarray.Coordinates({name: plain[name] for name in self.coords}, indexes)
        return xarray.Dataset({name: plain[name] for name in self.data_vars}, coords, self.attrs)


def write_table(table: Table, path: Path) -> None:
    """Write a table as netCDF-4.

    xarray's own writer would load every installed library that has arrays of its own.
    """
    from netCDF4 import Dataset

    with Dataset(path, "w") as file:
        # coordinates that are not dimensions must be listed in an attribute
        labels = [name for name, array in table.coords.items() if array.dims != (name,)]
        file.setncatts({**table.attrs, "coordinates": " ".join(labels)})
        for name, array in table.variables.items():
            kind = array.values.dtype
            for dim, size in zip(array.dims, array.values.shape, strict=True):
                if dim not in file.dimensions:
                    file.createDimension(dim, size)
            variable = file.createVariable(name, str if kind.kind in "UO" else kind, array.dims)
            variable.setncatts(array.attrs)
        # after all definitions: the library rewrites the header at each definition after data
        for name, variable in file.variables.items():
            values = table.variables[name].values
            variable[:] = values.astype(object) if values.dtype.kind in "UO" else values


def read_table(path: Path) -> Table:
    """Read a table that `write_table` has written."""
    from netCDF4 import Dataset

    with Dataset(path) as file:
        file.set_auto_maskandscale(False)
        variables = {}
        for name, array in file.variables.items():
            values = array[...].astype(str) if array.dtype is str else array[...]
            variables[name] = Variable(array.dimensions, values, array.__dict__)
        attrs = dict(file.__dict__)
    names = [*attrs.pop("coordinates").split(), *(variables.keys() & file.dimensions.keys())]
    coords = {name: variables.pop(name) for name in names}
    return Table(variables, coords, attrs)
