"""Write the files of a run: first the numbers, then figures, whose failure loses no number."""

import json
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ...meshes.errors import RingwearError
from ..problem.unit_names import NO_UNIT
from ..progress import LOG
from ..tables import write_csv
from .one_file import make

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from ..figures.style import Picture
    from ..outcome.outcome import Outcome
    from ..outcome.table import Table

INSIDE = "half_space.vtu"


def run_files(pictures: Iterable["Picture"]) -> set[str]:
    """Return the names of the files that a run with these pictures may write."""
    numbers = {"results.nc", "summary.json", "report.html", INSIDE}
    return numbers | {picture.file for picture in pictures}


def write_numbers(result: "Outcome", directory: Path, tables: bool = False) -> None:
    """Write `results.nc` and `summary.json` of a run, and CSV tables if `tables`."""
    LOG.info("  output  writing ...")
    try:
        write_netcdf(result.table, directory / "results.nc")
    except RuntimeError as error:
        # netCDF raises a RuntimeError if the disk is full
        raise RingwearError(
            f"results.nc could not be written ({error}): is the disk full?"
        ) from error
    summary = json.dumps(result.summary, indent=1, allow_nan=False)
    (directory / "summary.json").write_text(summary + "\n", "utf-8")
    if tables:
        write_tables(result.dataset, directory)


def write_netcdf(table: "Table", path: Path) -> None:
    """Write a table as netCDF-4, readable by `xarray.load_dataset`."""
    from netCDF4 import Dataset

    # coordinates that are not dimensions must be listed in an attribute
    labels = [name for name, (dims, *_) in table.coordinates.items() if name not in dims]
    with Dataset(path, "w") as file:
        file.setncatts(table.attributes | {"coordinates": " ".join(labels)})
        for name, (dims, values, attributes) in (table.coordinates | table.variables).items():
            for dim, size in zip(dims, values.shape, strict=True):
                if dim not in file.dimensions:
                    file.createDimension(dim, size)
            kind: type | np.dtype = str if values.dtype.kind == "U" else values.dtype
            variable = file.createVariable(name, kind, dims)
            variable[:] = values.astype(object) if kind is str else values
            variable.setncatts(attributes)


def write_tables(dataset: "xarray.Dataset", directory: Path) -> None:
    """Write all variables as CSV: one file for the variables of the same dimensions.

    The file is named after the dimensions, the column headings contain the units, and rows without
    any value are left out.
    """
    units = {name: dataset[name].attrs.get("units", NO_UNIT) for name in dataset.variables}
    heads = {name: f"{name} [{unit}]" for name, unit in units.items() if unit != NO_UNIT}
    for dims in {variable.dims for variable in dataset.values()}:
        names = [name for name in dataset if dataset[name].dims == dims]
        table = dataset[names].to_dataframe().dropna(how="all", subset=names).reset_index()
        if len(table):
            file = "_".join(map(str, dims)) + ".csv"
            write_csv(table.rename(columns=heads), directory / file)


def draw(result: "Outcome", pictures: Sequence["Picture"], directory: Path) -> list[str]:
    """Draw the pictures that a result has data for; return the failures, with reasons.

    Fields inside the half-space are written, too. They take as long as the contact problem, and are
    therefore left out without pictures unless the scene asks for them (`output.field_times`).
    """
    from .vtu import write_half_space

    LOG.info("  output  drawing ...")
    failures = []
    if result.has_inside and (pictures or result.scene.output.field_times):
        scene, series = result.scene, bool(result.scene.output.field_times)
        failures += make(
            directory / INSIDE, lambda path: write_half_space(result.inside, scene, path, series)
        )
    for picture in pictures:
        if picture.drawn_for(result):
            failures += make(directory / picture.file, partial(picture.write, result))
    return failures
