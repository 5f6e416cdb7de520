"""An output folder with either all old or all new files of a command; other files are not touched.

A command writes into a hidden directory, which is renamed when all files are complete. Then its
files are moved into the output folder; if this is interrupted, the next run completes it. A marker
file in the folder lists the files that each command has written: the next run of that command
replaces them. Files that are not listed are neither removed nor overwritten.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile

from .....meshes.errors import SceneError
from ....tables.writing import json_text
from ...problem.written import shown
from ...signals import STOPPED, signals_wait

MARKER = ".ringwear.json"
WRITING = ".writing"
# new name of the directory `WRITING` when its files are complete
COMPLETE = ".complete"


class Folder:
    """The output folder of a running command.

    Parameters
    ----------
    out : Path
        Path of the folder.
    command : str
        Name of the command, whose earlier files in the folder are replaced.

    Attributes
    ----------
    hidden : Path
        The directory to write to.
    written : list of str
        Files that have been put in place.
    published : bool
        Whether all files of the command have been put in place.
    """

    def __init__(self, out: Path, command: str) -> None:
        self.out, self.command = out, command
        self.hidden = out / WRITING
        self.written: list[str] = []
        self.published = False

    def refuse_to_replace(self, names: Iterable[str]) -> None:
        """Raise a SceneError if files not written by ringwear have these names."""
        foreign_files = set(os.listdir(self.out)) - _files_of_ringwear(self.out)
        if conflicts := sorted(foreign_files.intersection(names)):
            raise SceneError(
                f"--out {self.out} contains {', '.join(conflicts)}, which ringwear has not "
                "written: move it away, or give another directory"
            )

    def publish_so_far(self) -> None:
        """Put the files that are complete in place; they stay if the command fails afterwards."""
        with signals_wait():
            self.publish()
            self.create_hidden()

    def create_hidden(self) -> None:
        """Create the hidden directory, with a marker that it belongs to ringwear."""
        self.hidden.mkdir()
        (self.hidden / MARKER).write_text("{}\n", "utf-8")

    def publish(self) -> None:
        """Replace the command's earlier files by the new ones."""
        names = set(os.listdir(self.hidden)) - {MARKER}
        self.written = sorted({*self.written, *names})
        self.refuse_to_replace(names)
        files = {
            command: sorted(set(names).difference(self.written))
            for command, names in _files_by_command(self.out).items()
        }
        files[self.command] = self.written
        (self.hidden / MARKER).write_text(json_text(files) + "\n", "utf-8")
        self.hidden.rename(self.out / COMPLETE)
        put_in_place(self.out)


def put_in_place(out: Path) -> None:
    """Move the files of a complete hidden directory into the output folder, the marker last.

    If it is interrupted, another call completes it.
    """
    complete = out / COMPLETE
    if not os.path.lexists(complete):
        return
    if (complete / MARKER).exists():
        replaced = _files_of_ringwear(out) - _files_of_ringwear(complete)
        for name in replaced.intersection(os.listdir(out)):
            (out / name).unlink()
        for name in sorted(os.listdir(complete), key=MARKER.__eq__):
            os.replace(complete / name, out / name)
    complete.rmdir()


def refuse_foreign_folders(out: Path) -> None:
    """Refuse an output folder in which other files have the names of the hidden directories.

    Hidden directories of ringwear contain a marker or are empty.

    Raises
    ------
    SceneError
        if there is such a file or directory; the message names it
    """
    for name in (WRITING, COMPLETE):
        path = out / name
        if not os.path.lexists(path):
            continue
        real_directory = path.is_dir() and not path.is_symlink()
        if not real_directory or ((names := os.listdir(path)) and MARKER not in names):
            raise SceneError(
                f"--out {out} contains {name}, which ringwear has not written: move it away, or "
                "give another directory"
            )


def _files_by_command(folder: Path) -> dict[str, list[str]]:
    """Return the names of the files that each command has written into a folder."""
    try:
        files = json.loads((folder / MARKER).read_text("utf-8"))
        return {
            command: [name for name in names if isinstance(name, str)]
            for command, names in files.items()
            if isinstance(names, list)
        }
    except (OSError, ValueError, AttributeError):
        # without a valid marker, no file counts as written by ringwear
        return {}


def _files_of_ringwear(folder: Path) -> set[str]:
    """Return the names of the files that all commands have written into a folder."""
    return set[str]().union(*_files_by_command(folder).values())


def default_folder(source: str, prefix: str = "") -> Path:
    """Return the folder within `results` that is named after a scene, its file, or a study.

    Dots at the ends are left out: ``..`` would be a folder outside of `results`.
    """
    return Path("results") / f"{prefix}{Path(source).stem.strip('.') or 'scene'}"


def named_folder(out: object) -> Path:
    """Return a folder by its name.

    Raises
    ------
    SceneError
        if it is not a name, or if it is not UTF-8, which the netCDF library needs
    """
    if not isinstance(out, str | Path):
        raise SceneError(f"{shown(out)} is no folder: give its name, such as 'results/mine'")
    try:
        str(out).encode()
    except UnicodeEncodeError:
        raise SceneError(f"--out {out}: the name is not UTF-8; give another directory") from None
    return Path(out)


@contextmanager
def output_folder(out: str | Path, command: str, names: Iterable[str] = ()) -> Iterator[Folder]:
    """Lock a folder for a command, and move the files of the command there at the end.

    A command that fails leaves no files. The next run removes the files of a killed one.

    Parameters
    ----------
    names
        Names of the files that the command may write, as far as they are known beforehand.

    Raises
    ------
    SceneError
        if the folder cannot be written to, if another run uses it, or if files not written by
        ringwear have names that the command needs
    """
    out = named_folder(out)
    if os.path.lexists(out) and not out.is_dir():
        raise SceneError(f"--out {out} is not a directory: give a directory")
    out = out.resolve()
    new_folders = [folder for folder in (out, *out.parents) if not folder.exists()]
    with lock_folder(out):
        folder = Folder(out, command)
        refuse_foreign_folders(out)
        put_in_place(out)
        shutil.rmtree(folder.hidden, ignore_errors=True)
        try:
            folder.create_hidden()
            folder.refuse_to_replace(names)
            yield folder
            with signals_wait():
                folder.publish()
                folder.published = True
        except KeyboardInterrupt as stop:
            if not folder.written:
                raise
            what = "stopped after the work was done; the new results are in place in"
            if not folder.published:
                what = "stopped; what was complete is in place in"
            raise KeyboardInterrupt(f"{what} {out}") from stop
        finally:
            with signals_wait():
                shutil.rmtree(folder.hidden, ignore_errors=True)
                for directory in new_folders:
                    with suppress(OSError):
                        directory.rmdir()


@contextmanager
def lock_folder(out: Path) -> Iterator[None]:
    """Create a folder and lock it, so that no other run writes to it.

    The operating system holds the lock, and releases it when the process ends for any reason. Where
    folders cannot be locked, as on Windows, the lock is a hidden file in the folder.

    Raises
    ------
    SceneError
        if the folder cannot be written to, or if another run is writing to it
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=out).close()
        release = _lock(out)
    except BlockingIOError:
        raise SceneError(
            f"--out {out} is being written to by another run: wait for it, or give another "
            "directory"
        ) from None
    except OSError as error:
        raise SceneError(
            f"--out {out} cannot be written to: {error.strerror}; give another directory"
        ) from error
    try:
        yield
    finally:
        release()


def _lock(folder: Path) -> Callable[[], object]:
    """Lock a folder; return the function that releases the lock.

    Raises
    ------
    BlockingIOError
        if another process holds the lock
    """
    try:
        import fcntl
    except ImportError:
        return _lock_by_file(folder / ".ringwear.lock")
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:
        # the file system does not support locks
        pass
    return partial(os.close, handle)


def _lock_by_file(file: Path) -> Callable[[], object]:
    """Lock a folder by a file in it; return the function that releases the lock.

    Raises
    ------
    BlockingIOError
        if another process holds the lock
    """
    from filelock import FileLock, Timeout

    lock = FileLock(file, blocking=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise BlockingIOError from error

    def release() -> None:
        lock.release()
        file.unlink(missing_ok=True)

    return release


def make(path: Path, write: Callable[[Path], object]) -> list[str]:
    """Write a file; if that fails, remove it and return the reason, else an empty list."""
    try:
        write(path)
    except BaseException as error:
        path.unlink(missing_ok=True)
        if STOPPED.is_set():
            raise KeyboardInterrupt from error
        if not isinstance(error, Exception):
            raise
        reason, *_ = str(error).strip().splitlines() or [type(error).__name__]
        return [f"{path.name} could not be written: {reason}"]
    return []
