"""Write the table of all results as netCDF-4, and read it back."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...problem.written import one_line
from ..predictions.machine import refuse_large
from .checksums import CHECKSUMS

if TYPE_CHECKING:
    import xarray

RESULTS, SUMMARY = "results.nc", "summary.json"
"""Files of saved results: the table, and the summary, which has the checksums of both."""


def write_netcdf(dataset: "xarray.Dataset", path: Path) -> None:
    """Write a dataset as netCDF-4, with no more attributes than it has.

    xarray's own writer adds fill values, which checksums would have to leave out.
    """
    from netCDF4 import Dataset

    # coordinates that are not dimensions must be listed in an attribute
    labels = [str(name) for name in dataset.coords if name not in dataset.dims]
    structure = {"coordinates": " ".join(labels), CHECKSUMS: f"those of all arrays: {SUMMARY}"}
    with Dataset(path, "w") as file:
        file.setncatts(dataset.attrs | structure)
        for name, array in dataset.variables.items():
            values = array.values
            dims = [str(dim) for dim in array.dims]
            for dim, size in zip(dims, values.shape, strict=True):
                if dim not in file.dimensions:
                    file.createDimension(dim, size)
            kind: type | np.dtype = str if values.dtype.kind == "U" else values.dtype
            variable = file.createVariable(str(name), kind, dims)
            variable[:] = values.astype(object) if kind is str else values
            variable.setncatts(array.attrs)


def read_netcdf(path: Path) -> "xarray.Dataset":
    """Return the dataset that `write_netcdf` has written; its attributes include `CHECKSUMS`.

    Raises
    ------
    FileNotFoundError
        if there is no such file
    ValueError
        if the file is damaged, or if its contents would not fit into memory
    """
    import xarray
    from netCDF4 import Dataset

    if not path.exists():
        raise FileNotFoundError(2, "no such file", str(path))
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    try:
        with Dataset(path) as file:
            file.set_auto_maskandscale(False)
            refuse_large(path, sum(map(_bytes_of, file.variables.values())))
            attributes = _attributes_of(file)
            labels = str(attributes.pop("coordinates", "")).split()
            for name, variable in file.variables.items():
                values = variable[...]
                if variable.dtype is str:
                    values = np.array(values, dtype=str)
                array = variable.dimensions, values, _attributes_of(variable)
                is_label = name in labels or name in variable.dimensions
                (coordinates if is_label else variables)[name] = array
        return xarray.Dataset(variables, coordinates, attributes)
    # a damaged file can raise many kinds of errors
    except Exception as error:
        raise ValueError(f"{path.name} cannot be read as netCDF ({one_line(error)})") from error


def _attributes_of(holder: Any) -> dict[str, str]:
    """Return the attributes of a netCDF file or of one of its variables."""
    return {name: holder.getncattr(name) for name in holder.ncattrs()}


def _bytes_of(variable: Any) -> float:
    """Return how many bytes the values of a netCDF variable take in memory; texts take more."""
    size = 8.0 if variable.dtype is str else float(variable.dtype.itemsize)
    return size * float(np.prod(variable.shape, dtype=float))
