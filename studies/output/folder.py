"""An output folder, which is the old or the new one as a whole, and files of others in it stay.

A command writes into a hidden directory. Once all is complete, that is given another name, and from
then on its files take their places, if need be by the next run. A marker in the folder lists what
each command has put there: the next run of that command replaces it, and what is not listed is not
ringwear's, and neither removed nor written over.
"""

import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from ...meshes.errors import SceneError
from .signals import signals_wait

MARKER = ".ringwear.json"
WRITING = ".writing"
# what `WRITING` is called once it is complete
COMPLETE = ".complete"


class Folder:
    """The folder of a command, as long as it writes to it.

    Parameters
    ----------
    out : Path
        Where it is to be.
    command : str
        Whose earlier files there are replaced.

    Attributes
    ----------
    hidden : Path
        The directory to write to.
    written : list of str
        Files that have been put in place.
    """

    def __init__(self, out: Path, command: str) -> None:
        self.out, self.command = out, command
        self.hidden = out / WRITING
        self.written: list[str] = []

    def refuse_to_replace(self, names: Iterable[str]) -> None:
        """Raise a SceneError if files of others have these names."""
        there = set(os.listdir(self.out)) - _files_of_ringwear(self.out)
        if taken := sorted(there.intersection(names)):
            raise SceneError(
                f"--out {self.out} holds {', '.join(taken)}, which ringwear has not written: move "
                "it away, or give another directory"
            )

    def publish(self) -> None:
        """Put all that has been written in the place of the command's earlier files."""
        self.written = sorted(set(os.listdir(self.hidden)) - {MARKER})
        self.refuse_to_replace(self.written)
        files = {
            command: sorted(set(names).difference(self.written))
            for command, names in _files_by_command(self.out).items()
        }
        files[self.command] = self.written
        (self.hidden / MARKER).write_text(json.dumps(files) + "\n", "utf-8")
        self.hidden.rename(self.out / COMPLETE)
        put_in_place(self.out)


def put_in_place(out: Path) -> None:
    """Move what is complete to its place in a folder; the marker comes last.

    Wherever it is stopped, it can be gone on with.
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
    """Refuse folders of others that have the names of ours, which hold a marker or nothing.

    Raises
    ------
    SceneError
        naming the folder
    """
    for name in (WRITING, COMPLETE):
        path = out / name
        if not os.path.lexists(path):
            continue
        real = path.is_dir() and not path.is_symlink()
        if not real or ((names := os.listdir(path)) and MARKER not in names):
            raise SceneError(
                f"--out {out} holds {name}, which ringwear has not written: move it away, or give "
                "another directory"
            )


def _files_by_command(folder: Path) -> dict[str, list[str]]:
    """Return the names of files that each command has put into a folder."""
    try:
        files = json.loads((folder / MARKER).read_text("utf-8"))
        return {
            command: [name for name in names if isinstance(name, str)]
            for command, names in files.items()
            if isinstance(names, list)
        }
    except (OSError, ValueError, AttributeError):
        # it is damaged, or no marker: nothing is ringwear's
        return {}


def _files_of_ringwear(folder: Path) -> set[str]:
    """Return the names of files that all commands have put into a folder."""
    return set[str]().union(*_files_by_command(folder).values())


@contextmanager
def output_folder(out: Path, command: str, names: Iterable[str] = ()) -> Iterator[Folder]:
    """Hold a folder for a command; what that has written then takes its place there.

    Nothing is left of a command that fails, and a killed one is cleaned up after.

    Parameters
    ----------
    names
        Files that the command may write, as far as it knows beforehand.

    Raises
    ------
    SceneError
        if the folder cannot be written to, another run holds it, or files of others have names
        that are needed
    """
    if os.path.lexists(out) and not out.is_dir():
        raise SceneError(f"--out {out} is not a directory: give a directory")
    out = out.resolve()
    made = [folder for folder in (out, *out.parents) if not folder.exists()]
    with lock_folder(out):
        folder = Folder(out, command)
        refuse_foreign_folders(out)
        put_in_place(out)
        shutil.rmtree(folder.hidden, ignore_errors=True)
        published = False
        try:
            folder.hidden.mkdir()
            # by which the next run knows it for ours
            (folder.hidden / MARKER).write_text("{}\n", "utf-8")
            folder.refuse_to_replace(names)
            yield folder
            with signals_wait():
                folder.publish()
                published = True
        except KeyboardInterrupt as stop:
            if not published:
                raise
            raise KeyboardInterrupt(
                f"stopped when all was done; the new results are in place in {out}"
            ) from stop
        finally:
            with signals_wait():
                shutil.rmtree(folder.hidden, ignore_errors=True)
                for directory in made:
                    with suppress(OSError):
                        directory.rmdir()


@contextmanager
def lock_folder(out: Path) -> Iterator[None]:
    """Make a folder and be the only run that writes to it.

    The lock is the system's, and ends with the process, however that ends.

    Raises
    ------
    SceneError
        if it cannot be written to, or another run is writing to it
    """
    import fcntl

    try:
        out.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=out).close()
        handle = os.open(out, os.O_RDONLY)
    except OSError as error:
        raise SceneError(
            f"--out {out} cannot be written to: {error.strerror}; give another directory"
        ) from error
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise SceneError(
            f"--out {out} is being written to by another run: wait for it, or give another "
            "directory"
        ) from None
    except OSError:
        # the file system has no locks
        pass
    try:
        yield
    finally:
        os.close(handle)
