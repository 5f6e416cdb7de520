"""Write values and texts of users in messages, as they would write them and in one line."""

import re
from collections.abc import Mapping

# greatest number of characters of a value in messages
MOST_CHARACTERS = 60
TOO_DEEP = "lists or tables are nested too deeply; give those that studies/reference.md describes"
# ASCII and Latin-1 controls, line and paragraph separators, controls of the direction of writing,
# and halves of surrogate pairs, which stand for bytes that are not UTF-8
CONTROL_CHARACTER = re.compile("[\0-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def check_one_line(text: str) -> str:
    """Refuse a text with control characters, such as the end of a line.

    In a file of another program it could be a command, and on a terminal an escape sequence.
    """
    if found := CONTROL_CHARACTER.search(text):
        raise ValueError(
            f"{shown(text)} has the control character {shown(found[0])}: give one line of text "
            "without such characters"
        )
    return text


def visible(text: str) -> str:
    """Return a text in which escape sequences such as ``\\n`` stand for control characters."""
    return CONTROL_CHARACTER.sub(lambda found: ascii(found[0])[1:-1], text)


def shown(value: object) -> str:
    """Return a value as text, shortened to `MOST_CHARACTERS`; numbers of numpy as plain ones."""
    try:
        text = " ".join(repr(plain(value)).split())
    # Python does not write such numbers
    except ValueError:
        return "a number of thousands of digits"
    except RecursionError:
        return "a value that is nested too deeply"
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
