"""What is left in an output folder.

Whole sets, foreign files untouched, numbers whatever happens to a figure.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import count
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from ringwear.meshes.errors import SceneError
from ringwear.studies.cli import main
from ringwear.studies.output import folder as folder_module
from ringwear.studies.output.folder import MANIFEST, held

NUMBERS = {"results.nc", "summary.json"}
QUICK = ["run", "flat_punch", "--rtol", "1e-2"]


def visible(out: Path) -> set[str]:
    return {entry.name for entry in out.iterdir() if entry.name != MANIFEST}


def failing(patch: pytest.MonkeyPatch, stage: str, raised: BaseException) -> None:
    def stop(*_: Any, **__: Any) -> None:
        raise raised

    patch.setattr(stage, stop)


@pytest.mark.parametrize(
    "stage", ["crosscheck.run.solved_to_accuracy", "crosscheck.dataset.summary"]
)
def test_a_run_stopped_before_its_numbers_leaves_what_was_there(
    stage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = [*QUICK, "--methods", "direct", "--out", str(tmp_path)]
    assert main(arguments) == 0
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    failing(monkeypatch, f"ringwear.studies.{stage}", KeyboardInterrupt())
    assert main(arguments) == 1
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_a_new_folder_goes_with_a_run_that_wrote_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, "ringwear.studies.crosscheck.run.solved_to_accuracy", KeyboardInterrupt())
    assert main([*QUICK, "--out", str(tmp_path / "new" / "out")]) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("stage", ["figures.states.draw_steady", "report.page.write_report"])
def test_ctrl_c_while_drawing_leaves_what_was_there(
    stage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main([*QUICK, "--methods", "direct", "--no-figures", "--out", str(tmp_path)]) == 0
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    failing(monkeypatch, f"ringwear.studies.{stage}", KeyboardInterrupt())
    assert main([*QUICK, "--out", str(tmp_path)]) == 1
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("stage", "lost"),
    [
        ("crosscheck.interior.write_half_space", "half_space.vtu"),
        pytest.param("figures.states.draw_steady", "steady_state.png", marks=pytest.mark.slow),
        pytest.param("figures.mesh.draw_stress", "stress.png", marks=pytest.mark.slow),
    ],
)
def test_a_figure_that_fails_loses_itself_only(
    stage: str,
    lost: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([*QUICK, "--out", str(tmp_path / "whole")]) == 0
    failing(monkeypatch, f"ringwear.studies.{stage}", OSError(28, "No space left on device"))
    assert main([*QUICK, "--out", str(tmp_path / "out")]) == 1
    told = capsys.readouterr()
    assert [line for line in told.err.splitlines() if lost in line and "No space left" in line]
    # the answer is told all the same
    assert "steady wear rate" in told.out
    assert visible(tmp_path / "out") == visible(tmp_path / "whole") - {lost}


@pytest.mark.parametrize(
    "raised", [OSError(28, "No space left on device"), RuntimeError("NetCDF: HDF error")], ids=str
)
def test_numbers_that_cannot_be_written_are_told_and_leave_what_was_there(
    raised: Exception,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = [*QUICK, "--methods", "direct", "--no-figures", "--out", str(tmp_path)]
    assert main(arguments) == 0
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    capsys.readouterr()
    failing(monkeypatch, "xarray.Dataset.to_netcdf", raised)
    assert main(arguments) == 1
    (line,) = [
        line for line in capsys.readouterr().err.splitlines() if line.startswith("ringwear:")
    ]
    assert "could not be written" in line
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_any_title_can_be_drawn(tmp_path: Path) -> None:
    """Titles are plain text: no mathtext of theirs can fail."""
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'title = "$\\\\frac{1 \\\\alpha_ and a long story that has to be wrapped, '
        + 20 * "again and "
        + '"\n'
        'methods = ["direct"]\npunch = {radius = 1.0, rings = 2, wear_coefficients = [1.0, 2.0]}\n'
        "half_space = {plane_strain_modulus = 1.0}\nload = {normal_force = 1.0}\n",
        "utf-8",
    )
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 0
    assert "steady_state.png" in visible(tmp_path / "out")


def test_a_set_is_replaced_whole_and_foreign_files_are_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    (tmp_path / "summary.json").write_text("mine, too", "utf-8")
    assert main([*QUICK, "--methods", "mdr,direct", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "notes.txt" in told
    assert "summary.json.kept" in told
    assert (tmp_path / "notes.txt").read_text("utf-8") == "mine"
    assert (tmp_path / "summary.json.kept").read_text("utf-8") == "mine, too"
    assert "history.png" in visible(tmp_path)
    # figures of other numbers would lie about these
    assert main([*QUICK, "--methods", "direct", "--no-figures", "--out", str(tmp_path)]) == 0
    assert visible(tmp_path) == NUMBERS | {"notes.txt", "summary.json.kept"}
    assert json.loads((tmp_path / MANIFEST).read_text("utf-8")) == {"run": sorted(NUMBERS)}


def test_commands_do_not_take_each_others_files(tmp_path: Path) -> None:
    with held(tmp_path, "mesh") as folder:
        (folder.hidden / "mesh.vtu").touch()
        (folder.hidden / "mesh.png").touch()
    with held(tmp_path, "run") as folder:
        (folder.hidden / "results.nc").touch()
        (folder.hidden / "mesh.png").touch()
    assert visible(tmp_path) == {"mesh.vtu", "mesh.png", "results.nc"}
    with held(tmp_path, "mesh") as folder:
        (folder.hidden / "mesh.vtu").touch()
    assert visible(tmp_path) == {"mesh.vtu", "mesh.png", "results.nc"}


def test_a_damaged_manifest_takes_nothing_for_its_own(tmp_path: Path) -> None:
    (tmp_path / MANIFEST).write_text('{"run": ["../important", 3]', "utf-8")
    (tmp_path / "results.nc").write_text("mine", "utf-8")
    with held(tmp_path, "run") as folder:
        (folder.hidden / "results.nc").touch()
    assert (tmp_path / "results.nc.kept").read_text("utf-8") == "mine"


def test_the_second_of_two_runs_refuses(tmp_path: Path) -> None:
    with (
        held(tmp_path, "run"),
        pytest.raises(SceneError, match="another run"),
        held(tmp_path, "run"),
    ):
        pass


def test_what_a_killed_run_left_is_swept(tmp_path: Path) -> None:
    (tmp_path / ".writing-abc").mkdir()
    (tmp_path / ".writing-abc" / "results.nc").touch()
    with held(tmp_path, "run"):
        assert not (tmp_path / ".writing-abc").exists()


def write_set(out: Path, names: str, content: str, killed_at: int = 0) -> None:
    """Write files named by a letter each; kill the process at a line of the replacing, if asked."""
    lines = iter(range(1, killed_at + 1))

    def kill(frame: FrameType, event: str, _: object) -> Any:
        if event == "line" and next(lines) == killed_at:
            os.kill(os.getpid(), signal.SIGKILL)
        return kill if frame.f_code.co_filename == folder_module.__file__ else None

    with held(out, "run") as folder:
        for name in names:
            (folder.hidden / name).write_text(content, "utf-8")
        if killed_at:
            sys.settrace(kill)


def killed_while_replacing(out: Path, names: str, killed_at: int) -> bool:
    """Replace the files in a process that is killed at a line, or has ended before; whether
    it was.
    """
    child = os.fork()
    if child == 0:
        with suppress(BaseException):
            write_set(out, names, "new", killed_at)
        os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def contents(out: Path) -> dict[str, str]:
    return {
        file.name: file.read_text("utf-8")
        for file in out.iterdir()
        if not file.name.startswith(".")
    }


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux exchanges folders")
def test_a_folder_is_the_old_or_the_new_one_whenever_it_is_killed(tmp_path: Path) -> None:
    old, new = dict.fromkeys("abc", "old"), dict.fromkeys("bcd", "new")
    seen = []
    for line in count(1):
        out = tmp_path / str(line)
        with held(out, "mesh") as folder:
            (folder.hidden / "mesh.vtu").write_text("mesh", "utf-8")
        write_set(out, "abc", "old")
        killed = killed_while_replacing(out, "bcd", line)
        seen.append(contents(out))
        assert seen[-1] in (old | {"mesh.vtu": "mesh"}, new | {"mesh.vtu": "mesh"})
        # what the killed process left is swept by the next, which takes no file for another's
        write_set(out, "e", "newest")
        assert contents(out) == {"e": "newest", "mesh.vtu": "mesh"}
        assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(".")] == []
        assert [entry.name for entry in out.iterdir() if entry.name.startswith(".")] == [MANIFEST]
        if not killed:
            break
    assert old | {"mesh.vtu": "mesh"} in seen[:-1]
    assert new | {"mesh.vtu": "mesh"} in seen[:-1]


def test_beside_files_of_others_no_kill_loses_a_file_or_takes_one_for_theirs(
    tmp_path: Path,
) -> None:
    """They are replaced one by one: a kill may leave some old and some new; the next run
    mends it.
    """
    for line in count(1):
        out = tmp_path / str(line)
        write_set(out, "abc", "old")
        (out / "notes").write_text("mine", "utf-8")
        killed = killed_while_replacing(out, "bcd", line)
        assert set("bc") <= contents(out).keys()
        write_set(out, "e", "newest")
        assert contents(out) == {"e": "newest", "notes": "mine"}
        if not killed:
            break
    assert line > 10


def test_a_folder_in_which_a_shell_stands_is_not_exchanged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_set(tmp_path, "abc", "old")
    monkeypatch.chdir(tmp_path)
    write_set(tmp_path, "bcd", "new")
    assert sorted(entry.name for entry in Path.cwd().iterdir()) == [MANIFEST, "b", "c", "d"]


def test_an_exchanged_folder_can_be_read_by_whom_it_could_be(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir(mode=0o750)
    write_set(out, "abc", "new")
    assert out.stat().st_mode & 0o777 == 0o750


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_waits_until_files_are_in_place(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = signal.signal(number, signal.default_int_handler)
    exchange = folder_module._exchange_directories

    def interrupted(one: Path, other: Path) -> None:
        signal.raise_signal(number)
        exchange(one, other)

    monkeypatch.setattr(folder_module, "_exchange_directories", interrupted)
    try:
        write_set(tmp_path / "out", "abc", "old")
    except KeyboardInterrupt:
        pass
    else:
        pytest.fail("the signal was lost")
    finally:
        signal.signal(number, before)
    assert contents(tmp_path / "out") == dict.fromkeys("abc", "old")
    assert [entry.name for entry in tmp_path.iterdir()] == ["out"]


# what there is of a run when it is stopped: nothing, numbers half written, numbers, a figure
@pytest.mark.parametrize(
    "seen",
    [
        "",
        "results.nc",
        pytest.param("summary.json", marks=pytest.mark.slow),
        pytest.param("half_space.vtu", marks=pytest.mark.slow),
        pytest.param("history.png", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    "number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_signals_end_a_run_cleanly(number: signal.Signals, seen: str, tmp_path: Path) -> None:
    # where the tests themselves run in the background, the shell has told them to ignore SIGINT
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    code += "from ringwear.studies.cli import main; raise SystemExit(main())"
    out = tmp_path / "out"
    # thirty-two rings by finite elements take long enough
    scene = ["five_rings", "--rtol", "1e-2"] if seen else ["many_rings", "--rtol", "1e-6"]
    arguments = ["run", *scene, "--out", str(out)]
    run = subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stderr=subprocess.PIPE, text=True
    )
    for _ in range(3000):
        if any(out.glob(f".writing-*/{seen}")):
            break
        time.sleep(0.02)
    os.kill(run.pid, number)
    _, told = run.communicate(timeout=60)
    assert run.returncode == 1
    assert "stopped" in told
    assert "Traceback" not in told
    assert not out.exists()
