"""An output folder.

Held by one run at a time, its set of files replaced whole, files of others left alone.

Files are written into a hidden directory and put in place when all of them are complete. A small
file beside them, `.ringwear.json`, lists what each command has put there; nothing else is ever
removed or written over.
"""

import ctypes
import json
import os
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...meshes.errors import SceneError

MANIFEST, HIDDEN = ".ringwear.json", ".writing-"
# of Linux's renameat2: paths are as they stand, and the two change places
AT_FDCWD, RENAME_EXCHANGE = -100, 2


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
        """Put all that has been written in the place of the owner's earlier files.

        A folder that holds nothing but ringwear's files is exchanged for the new one in one step,
        so that it is the old or the new one whenever the process is killed. Elsewhere files are
        replaced one by one, and the earlier ones that no new one replaces are removed last.
        """
        foreign = self.foreign()
        written = sorted(file.name for file in self.hidden.iterdir())
        before = self._sets.pop(self.owner, [])
        others = {owner: sorted({*names} - {*written}) for owner, names in self._sets.items()}
        self._sets = {owner: names for owner, names in others.items() if names}
        self.published = written
        self._write_manifest(written)
        if foreign or not self._exchange():
            self._replace_one_by_one(before, foreign)

    def _exchange(self) -> bool:
        """Exchange the whole folder for the new one; returns whether that can be done here."""
        out = self.out.resolve()
        try:
            if Path.cwd().is_relative_to(out):
                # a shell that stands in the folder would be left in one that is gone
                return False
            for name in {name for names in self._sets.values() for name in names}:
                if (out / name).exists():
                    os.link(out / name, self.hidden / name)
            shutil.copymode(out, self.hidden)
            os.rename(self.hidden, _beside(out))
            self.hidden = _beside(out)
            _exchange_directories(self.hidden, out)
        except OSError:
            return False
        return True

    def _replace_one_by_one(self, before: list[str], foreign: list[str]) -> None:
        for name in self.published:
            place = self.out / name
            if name in foreign:
                aside = _free(place.with_name(f"{name}.kept"))
                os.rename(place, aside)
                self.notes.append(
                    f"{place} was there before and not ringwear's: kept as {aside.name}"
                )
        # whenever the process is killed, what is there is known to be ringwear's
        self._write_manifest({*before, *self.published})
        os.replace(self.hidden / MANIFEST, self.out / MANIFEST)
        for name in self.published:
            os.replace(self.hidden / name, self.out / name)
        for name in set(before).difference(self.published, *self._sets.values()):
            with suppress(OSError):
                (self.out / name).unlink()
        self._write_manifest(self.published)
        os.replace(self.hidden / MANIFEST, self.out / MANIFEST)

    def _write_manifest(self, names: Iterable[str]) -> None:
        sets = self._sets | {self.owner: sorted(names)}
        (self.hidden / MANIFEST).write_text(json.dumps(sets) + "\n", "utf-8")

    def foreign(self) -> list[str]:
        """Files in the folder that ringwear has not put there."""
        own = {
            MANIFEST,
            *self.published,
            *(name for names in self._sets.values() for name in names),
        }
        return sorted(
            entry.name
            for entry in self.out.iterdir()
            if entry.name not in own and entry != self.hidden
        )


@contextmanager
def held(out: Path, owner: str) -> Iterator[Folder]:
    """The folder, writable and nobody else's until the end.

    What is in its hidden directory then moves into place.

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
        for left in (*out.glob(f"{HIDDEN}*"), _beside(out.resolve())):
            # of a run that was killed: nobody holds the folder now
            shutil.rmtree(left, ignore_errors=True)
        hidden = Path(tempfile.mkdtemp(prefix=HIDDEN, dir=out))
    except OSError as error:
        raise SceneError(
            f"--out {out} cannot be written to: {error.strerror}; give another directory"
        ) from error
    folder = Folder(out, owner, hidden)
    try:
        yield folder
        with signals_wait():
            folder.publish()
    finally:
        with signals_wait():
            shutil.rmtree(folder.hidden, ignore_errors=True)
            if lock is not None:
                os.close(lock)
            for empty in made:
                with suppress(OSError):
                    empty.rmdir()


@contextmanager
def signals_wait() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM wait until what is done to files is done."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[int] = []
    numbers = signal.SIGINT, signal.SIGTERM
    handlers = [
        signal.signal(number, lambda number, _: waiting.append(number)) for number in numbers
    ]
    try:
        yield
    finally:
        for number, handler in zip(numbers, handlers, strict=True):
            signal.signal(number, handler)
        for late in waiting[:1]:
            signal.raise_signal(late)


def _beside(out: Path) -> Path:
    """The hidden directory that is exchanged with a folder."""
    return out.with_name(f".{out.name}{HIDDEN}")


def _exchange_directories(one: Path, other: Path) -> None:
    """Let two directories change places in one step.

    Raises
    ------
    OSError
        where the system, or the file system, cannot
    """
    if sys.platform != "linux":
        raise OSError("only Linux exchanges directories")
    library = ctypes.CDLL(None, use_errno=True)
    if not hasattr(library, "renameat2"):
        raise OSError("the C library is older than renameat2")
    paths = os.fsencode(one), os.fsencode(other)
    if library.renameat2(AT_FDCWD, paths[0], AT_FDCWD, paths[1], RENAME_EXCHANGE):
        raise OSError(ctypes.get_errno(), "directories cannot be exchanged")


def _locked(out: Path) -> int | None:
    """A lock on the folder that ends with the process, however it ends.

    None where there is no such thing.
    """
    try:
        from fcntl import LOCK_EX, LOCK_NB, flock
    except ImportError:
        return None
    handle = os.open(out, os.O_RDONLY)
    try:
        flock(handle, LOCK_EX | LOCK_NB)
        if not os.path.samestat(os.fstat(handle), out.stat()):
            raise BlockingIOError("another run has exchanged the folder in the meantime")
    except BlockingIOError:
        os.close(handle)
        raise SceneError(
            f"--out {out} is being written to by another run: wait for it, or give another "
            "directory"
        ) from None
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
    return (
        path
        if not os.path.lexists(path)
        else next(one for one in numbers if not os.path.lexists(one))
    )
