"""The files of a run and of a mesh: numbers, then what shows them, which loses no number."""

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
    """Return the names of the files that a run with some pictures may write."""
    numbers = {"results.nc", "summary.json", "report.html", INSIDE}
    return numbers | {picture.file for picture in pictures}


def write_numbers(result: "Outcome", directory: Path, tables: bool = False) -> None:
    """Write the numbers of a run, if wanted as CSV tables, too."""
    LOG.info("  output  writing ...")
    try:
        write_netcdf(result.table, directory / "results.nc")
    except RuntimeError as error:
        # what netCDF makes of a full disk
        raise RingwearError(
            f"results.nc could not be written ({error}): is the disk full?"
        ) from error
    summary = json.dumps(result.summary, indent=1, allow_nan=False)
    (directory / "summary.json").write_text(summary + "\n", "utf-8")
    if tables:
        write_tables(result.dataset, directory)


def write_netcdf(table: "Table", path: Path) -> None:
    """Write a table as `xarray.load_dataset` reads it."""
    from netCDF4 import Dataset

    # coordinates that are no dimensions
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
    """Write every variable as CSV, those of the same dimensions in one file, named by these.

    Units are in the heads; rows that a method does not give are left out.
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
    """Draw those pictures that a result has; return what could not be made, with the reason.

    The inside of the half-space takes as long as the contact: without pictures it is left out
    unless the scene asks for it.
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
