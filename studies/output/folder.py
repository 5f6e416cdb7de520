"""An output folder, which is the old or the new one as a whole, and files of others in it stay.

A command writes into a hidden directory, which takes the place of the folder by a rename once all
is complete. A marker in the folder lists what each command has put there: the next run of that
command replaces it, files of other commands are carried over, and what is not listed is not
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
        self.hidden = out / ".writing"
        self.written: list[str] = []
        try:
            self._marked: dict[str, list[str]] = json.loads((out / MARKER).read_text("utf-8"))
        except (OSError, ValueError):
            self._marked = {}

    def foreign(self) -> set[str]:
        """Return the names of files in the folder that are not ringwear's."""
        ours = {MARKER, self.hidden.name}.union(*self._marked.values())
        return set(os.listdir(self.out)) - ours

    def refuse_to_replace(self, names: Iterable[str]) -> None:
        """Raise a SceneError if files of others have these names."""
        if taken := sorted(self.foreign().intersection(names)):
            raise SceneError(
                f"--out {self.out} holds {', '.join(taken)}, which ringwear has not written: move "
                "it away, or give another directory"
            )

    def publish(self) -> None:
        """Put all that has been written in the place of the command's earlier files."""
        written = set(os.listdir(self.hidden))
        self.refuse_to_replace(written)
        earlier = set(self._marked.pop(self.command, ()))
        self._marked = {
            command: sorted(set(names) - written) for command, names in self._marked.items()
        }
        foreign, carried = self.foreign() - earlier, set().union(*self._marked.values())
        self._marked[self.command] = self.written = sorted(written)
        (self.hidden / MARKER).write_text(json.dumps(self._marked) + "\n", "utf-8")
        if foreign or not self._swap(carried):
            for name in (earlier - written - carried).intersection(os.listdir(self.out)):
                (self.out / name).unlink()
            # whenever the process is killed, what is there is known to be ringwear's
            for name in (MARKER, *self.written):
                os.replace(self.hidden / name, self.out / name)

    def _swap(self, carried: set[str]) -> bool:
        """Let the new folder take the place of the old one; return whether it can."""
        try:
            if Path.cwd().is_relative_to(self.out):
                # a shell that stands in the folder would be left in one that is gone
                return False
            for name in carried.intersection(os.listdir(self.out)):
                shutil.copy2(self.out / name, self.hidden / name)
            shutil.copymode(self.out, self.hidden)
            self.hidden = self.hidden.rename(_beside(self.out, "new"))
            self.out.rename(_beside(self.out, "old"))
            self.hidden.rename(self.out)
        except OSError:
            # the folder is a mount point, or nothing may be made beside it
            return False
        shutil.rmtree(_beside(self.out, "old"), ignore_errors=True)
        return True


def _beside(out: Path, age: str) -> Path:
    return out.with_name(f".{out.name}.{age}")


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
    old, new = _beside(out, "old"), _beside(out, "new")
    if old.exists() and not out.exists():
        old.rename(out)
    with lock_folder(out):
        folder = Folder(out, command)
        for leftover in (old, new, folder.hidden):
            shutil.rmtree(leftover, ignore_errors=True)
        try:
            folder.hidden.mkdir()
            folder.refuse_to_replace(names)
            yield folder
            with signals_wait():
                folder.publish()
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

    # a Path of "s3://bucket" has one slash left
    if ":/" in str(out):
        raise SceneError(f"--out {out} is no directory of this machine: give one, and copy from it")
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
