"""Write the files of a run: first the numbers, then figures, whose failure loses no number."""

import json
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .....meshes.errors import RingwearError
from ....tables import write_csv
from ...problem.unit_names import NO_UNIT
from ...progress import LOG
from .checksums import CHECKSUMS, FILE, Json, checksums, digest_of_file
from .netcdf import RESULTS, SUMMARY, write_netcdf
from .one_file import make

if TYPE_CHECKING:
    import xarray

    from ....figures.style import Picture
    from ..outcome import Outcome

INSIDE = "half_space.vtu"


def run_files(pictures: Iterable["Picture"]) -> set[str]:
    """Return the names of the files that a run with these pictures may write."""
    numbers = {RESULTS, SUMMARY, "report.html", INSIDE}
    return numbers | {picture.file for picture in pictures}


def write_numbers(result: "Outcome", directory: Path, tables: bool = False) -> None:
    """Write `results.nc` and `summary.json` of a run, and CSV tables if `tables`."""
    LOG.info("  output  writing ...")
    entries = result.summary
    # before anything is written, so that they are those of the results in memory
    recorded: Json = {**checksums(result.dataset, entries)}
    try:
        write_netcdf(result.dataset, directory / RESULTS)
    except RuntimeError as error:
        # netCDF raises a RuntimeError if the disk is full
        raise RingwearError(
            f"results.nc could not be written ({error}): is the disk full?"
        ) from error
    recorded[FILE] = digest_of_file(directory / RESULTS)
    summary = json.dumps(entries | {CHECKSUMS: recorded}, indent=1, allow_nan=False)
    (directory / SUMMARY).write_text(summary + "\n", "utf-8")
    if tables:
        write_tables(result.dataset, directory)


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
