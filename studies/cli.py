"""The command line: streams, signals and errors around the commands (`commands.py`).

Exit status:

- 0: done, and the methods do not disagree;
- 1: any other failure, such as a figure that could not be drawn or failed scenes of a sweep, or an
  interruption by Ctrl-C, SIGTERM or SIGHUP (finished rows of a study and scenes of a sweep are
  kept); or all is done and all files are written, but standard output could not be written;
- 2: bad input;
- 3: done, but the methods disagree, or a method cannot reach `rtol`, or checked results have larger
  errors than allowed, or a model does not fit the measurements.
"""

import gc
import os
import sys

from ..meshes import RingwearError, SceneError
from .crosscheck import STOPPED, ending_on_signals, signals_wait
from .report.streams import print_error, tolerant_streams
from .status import Status

STOPPED_IN_WORDS = "stopped; no incomplete files are left"


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    with tolerant_streams() as output:
        status = _status_of(arguments)
        output.flush()
        # a reader such as `head`, which has read enough, closes a pipe
        if output.failure is None or isinstance(output.failure, BrokenPipeError):
            return status
        reason = getattr(output.failure, "strerror", None) or output.failure
        print_error(f"standard output could not be written: {reason}; no file is affected")
        return status or Status.FAILED


def _status_of(arguments: list[str] | None) -> Status:
    """Conduct a command, and print the message of an error in one line."""
    # collect garbage less often: most objects live to the end of a command, and to search them
    # takes a tenth of a run
    gc.set_threshold(1_000_000, 50, 50)
    try:
        with ending_on_signals():
            # modules are loaded here, where an interruption is handled, and not at the top of this
            # file; one that is interrupted while it is loaded fails in other ways
            with signals_wait():
                from .arguments import read_arguments
            read = read_arguments(sys.argv[1:] if arguments is None else arguments)
            if arguments is None and read["command"] == "run":
                # its matrices are small, and the threads of two libraries would wait for each other
                os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
            with signals_wait():
                from .commands import conduct
            return conduct(**read, only=arguments is None)
    except KeyboardInterrupt as stop:
        message = str(stop) or STOPPED_IN_WORDS
    except SceneError as error:
        print_error(str(error))
        return Status.BAD_INPUT
    except RingwearError as error:
        message = str(error)
    except OSError as error:
        message = f"{error.filename or 'a file'} could not be written: {error.strerror or error}"
    except Exception:
        # a library may have caught the KeyboardInterrupt as an error of its own
        if not STOPPED.is_set():
            raise
        message = STOPPED_IN_WORDS
    print_error(message)
    return Status.FAILED


if __name__ == "__main__":
    sys.exit(main())
