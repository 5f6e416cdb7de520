"""Checksums of saved results, which reveal files that were changed, damaged or mixed."""

from hashlib import sha256
from pathlib import Path
from typing import Any

from ....tables.writing import json_text

Json = dict[str, Any]

RESULTS, SUMMARY = "results.nc", "summary.json"
"""Files of saved results: the table, and the summary, which has the checksums of both."""

CHECKSUMS = "checksums"
"""Entry of `summary.json` with the checksums, and attribute of `results.nc` that points to it."""


def checksums(directory: Path, entries: Json) -> dict[str, str]:
    """Return the SHA-256 checksums of the table, byte for byte, and of the entries of the summary.

    Parameters
    ----------
    directory : folder with `results.nc`
    entries : content of `summary.json` without its checksums
    """
    text = json_text(entries, sort_keys=True)
    contents = {RESULTS: (directory / RESULTS).read_bytes(), SUMMARY: text.encode()}
    return {name: sha256(content).hexdigest() for name, content in contents.items()}
