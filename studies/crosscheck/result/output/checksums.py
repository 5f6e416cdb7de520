"""Checksums of saved results, which reveal files that were changed, damaged or mixed.

They are computed from the results in memory, not from the files. They therefore also reveal an
array that was altered while it was written.
"""

from hashlib import file_digest, sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....tables.writing import json_text
from ...problem.written import shown

if TYPE_CHECKING:
    import xarray

Json = dict[str, Any]
CHECKSUMS = "checksums"
"""Entry of `summary.json` with the checksums, and attribute of `results.nc` that points to it."""
FILE = "results.nc"
"""Entry of the checksums with that of the whole file `results.nc`, as it was written."""
PLACES = {
    "coordinates": "coordinate {} of results.nc",
    "variables": "variable {} of results.nc",
    "attributes": "attribute {} of results.nc",
    "summary": "entry {} of summary.json",
}
"""Groups of checksums, and what each of their names refers to."""


def checksums(dataset: "xarray.Dataset", entries: Json) -> dict[str, dict[str, str]]:
    """Return the SHA-256 checksums of results in memory, by group (`PLACES`) and name.

    The checksum of an array covers its name, dimensions, shape, type, attributes and values.

    Parameters
    ----------
    dataset : content of `results.nc`
    entries : content of `summary.json` without its checksums
    """
    return {
        "coordinates": {str(name): _of_array(array) for name, array in dataset.coords.items()},
        "variables": {str(name): _of_array(array) for name, array in dataset.data_vars.items()},
        "attributes": {str(name): _of_json(value) for name, value in dataset.attrs.items()},
        "summary": {name: _of_json(value) for name, value in entries.items()},
    }


def digest_of_file(path: Path) -> str:
    """Return the SHA-256 checksum of a file."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()


def first_mismatch(recorded: object, dataset: "xarray.Dataset", entries: Json) -> str:
    """Return in words what does not match its recorded checksum; empty if everything matches.

    Parameters
    ----------
    recorded : checksums as they were read from `summary.json`, of any type
    dataset, entries : results as they were read, as for `checksums`
    """
    for group, computed in checksums(dataset, entries).items():
        sums = recorded.get(group) if isinstance(recorded, dict) else None
        if not isinstance(sums, dict):
            return f"the checksums in summary.json have no group {shown(group)}"
        for name in dict.fromkeys([*sums, *computed]):
            place = PLACES[group].format(shown(name))
            if name not in computed:
                return f"{place} is missing"
            if name not in sums:
                return f"{place} has no checksum in summary.json"
            if sums[name] != computed[name]:
                return f"{place} does not match its checksum in summary.json"
    return ""


def _of_array(array: "xarray.DataArray") -> str:
    values, dims = array.values, array.dims
    description: Json = {"name": array.name, "dims": dims, "shape": values.shape}
    description["labels"] = array.attrs
    if values.dtype.kind == "U":
        return _of_json(description | {"texts": values.tolist()})
    # the same bytes on machines of any byte order
    kind = values.dtype.newbyteorder("<")
    digest = sha256(_canonical(description | {"type": kind.str}))
    digest.update(values.astype(kind).tobytes())
    return digest.hexdigest()


def _of_json(value: object) -> str:
    return sha256(_canonical(value)).hexdigest()


def _canonical(value: object) -> bytes:
    """Return a value as JSON without blanks and with sorted keys.

    Attributes of a damaged file may be of a type that JSON does not have.
    """
    return json_text(value, sort_keys=True, separators=(",", ":"), default=repr).encode()
