"""Write values of users in messages as they would write them."""

import re
from collections.abc import Mapping

# greatest number of characters of a value in messages
MOST_CHARACTERS = 60


def shown(value: object) -> str:
    """Return a value as text, shortened to `MOST_CHARACTERS`; numbers of numpy as plain ones."""
    text = " ".join(repr(plain(value)).split())
    return text if len(text) <= MOST_CHARACTERS else f"{text[: MOST_CHARACTERS - 4]} ..."


def one_line(error: Exception) -> str:
    """Return the first sentence of the message of another package, in one line, without a path."""
    text = str(getattr(error, "strerror", None) or error)
    return re.split(r"[.;] ", next(iter(text.splitlines()), ""))[0].rstrip(".:")


def plain(value: object) -> object:
    """Return numbers, texts and arrays of numpy as those of Python, in containers, too."""
    if isinstance(value, Mapping):
        return {plain(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        entries = [plain(entry) for entry in value]
        return entries if isinstance(value, list) else tuple(entries)
    # arrays and numbers of numpy, but neither tables nor datasets
    as_list = getattr(value, "tolist", None)
    return as_list() if callable(as_list) else value
