"""An output folder: held by one run at a time, its set of files replaced whole, files of others left alone.

Files are written into a hidden directory and moved into place when they are complete. A small file beside them,
`.ringwear.json`, lists what each command has put there; nothing else is ever removed or written over.
"""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ringwear.meshes.errors import SceneError

MANIFEST, HIDDEN = ".ringwear.json", ".writing-"


class Folder:
    """The folder of one run, as long as it lasts.

    Parameters
    ----------
    out : the folder
    owner : the command, whose earlier files there are replaced
    hidden : the directory to write to
    """

    def __init__(self, out: Path, owner: str, hidden: Path) -> None:
        self.out, self.owner, self.hidden = out, owner, hidden
        self.published: list[str] = []
        self.notes: list[str] = []
        self._sets: dict[str, list[str]] = _manifest(out)

    def publish(self) -> None:
        """Move all that has been written into place; the first time, the owner's earlier files go."""
        written = sorted(file.name for file in self.hidden.iterdir())
        before = set(self._sets.pop(self.owner, ())) if not self.published else set()
        known = before.union(self.published, *self._sets.values())
        for name in written:
            place = self.out / name
            if os.path.lexists(place) and name not in known:
                aside = _free(place.with_name(f"{name}.kept"))
                os.rename(place, aside)
                self.notes.append(f"{place} was there before and not ringwear's: kept as {aside.name}")
            os.replace(self.hidden / name, place)
        for name in before.difference(written):
            with suppress(OSError):
                (self.out / name).unlink()
        self.published = sorted({*self.published, *written})
        self._sets = {owner: left for owner, names in self._sets.items() if (left := sorted({*names} - {*written}))}
        (self.hidden / MANIFEST).write_text(json.dumps(self._sets | {self.owner: self.published}) + "\n", "utf-8")
        os.replace(self.hidden / MANIFEST, self.out / MANIFEST)

    def foreign(self) -> list[str]:
        """Files in the folder that ringwear has not put there."""
        own = {MANIFEST, *self.published, *(name for names in self._sets.values() for name in names)}
        return sorted(entry.name for entry in self.out.iterdir() if entry.name not in own and entry != self.hidden)


@contextmanager
def held(out: Path, owner: str) -> Iterator[Folder]:
    """The folder, writable and nobody else's until the end; what is in its hidden directory then moves into place.

    Raises
    ------
    SceneError
        if it cannot be written to, or another run holds it
    """
    if os.path.lexists(out) and not out.is_dir():
        what = "a link that leads nowhere" if out.is_symlink() and not out.exists() else "a file"
        raise SceneError(f"--out {out} is {what}: give a directory")
    made = [folder for folder in (out, *out.parents) if not folder.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = _locked(out)
        for left in out.glob(f"{HIDDEN}*"):
            # of a run that was killed: nobody holds the folder now
            shutil.rmtree(left, ignore_errors=True)
        hidden = Path(tempfile.mkdtemp(prefix=HIDDEN, dir=out))
    except OSError as error:
        raise SceneError(f"--out {out} cannot be written to: {error.strerror}; give another directory") from error
    try:
        folder = Folder(out, owner, hidden)
        yield folder
        folder.publish()
    finally:
        shutil.rmtree(hidden, ignore_errors=True)
        if lock is not None:
            os.close(lock)
        for empty in made:
            with suppress(OSError):
                empty.rmdir()


def _locked(out: Path) -> int | None:
    """A lock on the folder that ends with the process, however it ends; None where there is no such thing."""
    try:
        from fcntl import LOCK_EX, LOCK_NB, flock
    except ImportError:
        return None
    handle = os.open(out, os.O_RDONLY)
    try:
        flock(handle, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise SceneError(f"--out {out} is being written to by another run: wait for it, or give another directory") from None
    except OSError:
        # a file system without locks
        os.close(handle)
        return None
    return handle


def _manifest(out: Path) -> dict[str, list[str]]:
    """What each command has put into a folder before; nothing if that cannot be read."""
    try:
        found = json.loads((out / MANIFEST).read_text("utf-8"))
        return {str(owner): [Path(name).name for name in names] for owner, names in found.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _free(path: Path) -> Path:
    """The path, or with a number after it if it is taken."""
    numbers = (path.with_name(f"{path.name}.{number}") for number in range(1, 10_000))
    return path if not os.path.lexists(path) else next(one for one in numbers if not os.path.lexists(one))
