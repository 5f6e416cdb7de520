"""An output folder has the old or the new files as a whole after a kill, a signal or a second run.

Files of other people are never removed or claimed.
"""

import os
import signal
import sys
from contextlib import suppress
from itertools import count

import pytest

from ringwear import SceneError
from ringwear.studies.crosscheck.result.output import folder as folder_module
from ringwear.studies.crosscheck.result.output.folder import MARKER, output_folder


def contents(out):
    files = (entry for entry in out.iterdir() if entry.is_file())
    return {file.name: file.read_bytes() for file in files if file.name != MARKER}


def test_a_damaged_marker_claims_no_files_for_ringwear(tmp_path):
    (tmp_path / MARKER).write_text('{"run": ["../important", 3]', "utf-8")
    (tmp_path / "a").write_text("mine", "utf-8")
    with pytest.raises(SceneError, match="has not written"):
        write(tmp_path, "a", "new")
    assert contents(tmp_path) == {"a": b"mine"}


def test_the_second_of_two_simultaneous_runs_is_refused(tmp_path):
    with (
        output_folder(tmp_path, "run"),
        pytest.raises(SceneError, match="another run"),
        output_folder(tmp_path, "run"),
    ):
        pass


def write(out, names, content, command="run", killed_at=0):
    """Write files named by one letter each; kill the process at a line of `folder.py` if asked."""
    lines = iter(range(1, killed_at + 1))

    def kill(frame, event, _):
        if event == "line" and next(lines) == killed_at:
            os.kill(os.getpid(), signal.SIGKILL)
        return kill if frame.f_code.co_filename == folder_module.__file__ else None

    with output_folder(out, command) as folder:
        for name in names:
            (folder.hidden / name).write_text(content, "utf-8")
        if killed_at:
            sys.settrace(kill)


@pytest.mark.slow
@pytest.mark.parametrize("foreign", ["", "notes"])
def test_a_killed_run_leaves_the_old_or_the_new_folder(foreign, tmp_path):
    """The next run restores the folder, and never removes or claims a file of other people."""
    mine = {"mesh": b"mesh"} | ({foreign: b"mine"} if foreign else {})
    old, new = dict.fromkeys("abc", b"old") | mine, dict.fromkeys("bcd", b"new") | mine
    seen = []
    for line in count(1):
        out = tmp_path / str(line)
        write(out, ["mesh"], "mesh", "mesh")
        write(out, "abc", "old")
        if foreign:
            (out / foreign).write_text("mine", "utf-8")
        child = os.fork()
        if child == 0:
            with suppress(BaseException):
                write(out, "bcd", "new", killed_at=line)
            os._exit(0)
        killed = os.WIFSIGNALED(os.waitpid(child, 0)[1])
        # the next run repairs the folder of the killed one, even if it is stopped itself
        with suppress(KeyboardInterrupt), output_folder(out, "run"):
            seen.append(contents(out))
            raise KeyboardInterrupt
        assert seen[-1] in (old, new)
        write(out, "e", "newest")
        assert contents(out) == {"e": b"newest"} | mine
        assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(".")] == []
        if not killed:
            break
    assert old in seen[:-1]
    assert new in seen[:-1]


def test_what_was_complete_stays_if_the_rest_is_stopped(tmp_path):
    out = tmp_path / "out"
    write(out, "xy", "old")

    def stopped():
        with output_folder(out, "run") as folder:
            (folder.hidden / "a").write_text("new")
            folder.publish_so_far()
            assert contents(out) == {"a": b"new"}
            (folder.hidden / "b").write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="what was complete is in place"):
        stopped()
    assert contents(out) == {"a": b"new"}
    with output_folder(out, "run") as folder:
        (folder.hidden / "a").write_text("newer")
        folder.publish_so_far()
        (folder.hidden / "b").write_text("newer")
    assert folder.written == ["a", "b"]
    assert contents(out) == dict.fromkeys("ab", b"newer")
    write(out, "c", "newest")
    assert contents(out) == {"c": b"newest"}
