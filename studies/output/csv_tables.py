"""The results as CSV tables, one for each set of dimensions, with units in the heads of the
columns.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray

# what depends on which dimensions, besides the method
TABLES = {
    (): "punch",
    ("time",): "over_time",
    ("time", "radius"): "over_time_and_radius",
    ("time", "ring"): "ring_forces",
    ("time", "edge"): "contact_edges",
    ("radius",): "steady_over_radius",
    ("ring",): "worn_volumes",
    ("state", "ring"): "rings",
    ("mode",): "relaxation_times",
}


def write_csv(dataset: "xarray.Dataset", directory: Path) -> None:
    """Write every variable of the results; rows that a method does not give are left out."""
    for dims, name in TABLES.items():
        own = [
            str(key) for key, value in dataset.data_vars.items() if value.dims == ("solver", *dims)
        ]
        if all(dataset.sizes.get(dim) for dim in dims):
            units = {
                key: dataset[key].attrs.get("units", dataset.attrs["units"])
                for key in dataset.variables
            }
            heads = {
                key: f"{key} [{unit}]"
                for key, unit in units.items()
                if unit != dataset.attrs["units"]
            }
            table = dataset[own].to_dataframe().dropna(how="all", subset=own).reset_index()
            table.rename(columns=heads).to_csv(directory / f"{name}.csv", index=False)
