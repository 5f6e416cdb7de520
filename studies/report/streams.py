"""Standard output and standard error that end no work when they cannot be written.

The disk of a log may be full, a terminal may be closed, and a descriptor may not be open at all.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

from ..crosscheck import visible


def print_error(message: str) -> None:
    """Print a message in one line on standard error."""
    print(f"ringwear: {visible(message)}", file=sys.stderr)


class TolerantStream:
    """A text stream that drops what it cannot write, and keeps the first error.

    Characters that its encoding does not have are written as escape sequences.

    Parameters
    ----------
    stream : the stream to write to; None if its descriptor was closed when Python started

    Attributes
    ----------
    failure : the error because of which nothing more is written; None if there was none
    """

    def __init__(self, stream: TextIO | None) -> None:
        self.stream = stream
        self.failure: OSError | ValueError | None = None

    def __getattr__(self, name: str) -> object:
        """Return an attribute of the stream, such as its encoding."""
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        """Write a text if that is possible; return its length."""
        if self.stream is not None and self.failure is None:
            encoding = getattr(self.stream, "encoding", None) or "utf-8"
            try:
                self.stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
            except (OSError, ValueError) as error:
                self._fail(self.stream, error)
        return len(text)

    def flush(self) -> None:
        """Pass the text on that was written so far, if that is possible."""
        if self.stream is not None and self.failure is None:
            try:
                self.stream.flush()
            except (OSError, ValueError) as error:
                self._fail(self.stream, error)

    def isatty(self) -> bool:
        """Return whether the stream is an open terminal."""
        with suppress(ValueError):
            return self.stream is not None and self.stream.isatty()
        return False

    def _fail(self, stream: TextIO, error: OSError | ValueError) -> None:
        self.failure = error
        # Python writes the rest of its buffer at exit, and would fail again
        with suppress(OSError, ValueError):
            sink = os.open(os.devnull, os.O_WRONLY)
            os.dup2(sink, stream.fileno())
            os.close(sink)


@contextmanager
def tolerant_streams() -> Iterator[TolerantStream]:
    """Make both streams tolerant within the `with` block; yield standard output."""
    _open_descriptors()
    output, errors = sys.stdout, sys.stderr
    tolerant_output, tolerant_errors = TolerantStream(output), TolerantStream(errors)
    # they have all methods that `print` and `argparse` use
    sys.stdout, sys.stderr = tolerant_output, tolerant_errors
    try:
        yield tolerant_output
    finally:
        tolerant_output.flush()
        tolerant_errors.flush()
        sys.stdout, sys.stderr = output, errors


def _open_descriptors() -> None:
    """Open standard descriptors that are closed.

    A file of results would otherwise become the standard output of a library.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # the system gives the lowest number that is free
            os.open(os.devnull, os.O_RDWR)
