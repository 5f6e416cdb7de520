"""Files of other people, and malformed files: none is lost, and each is reported in one line."""

import os
import signal

import netCDF4
import pytest
import tomli_w
from groups import nightly

from ringwear import Scene

# list of the files in a folder that ringwear has written
MARKER = ".ringwear.json"
MAP = 'base = "five_rings"\nkeep = ["steady_wear_rate"]\n[axes]\n"punch.rings" = [2, 4]\n'
DIRECT = "run flat_punch --rtol 1e-2 --methods direct --no-figures --out out"


def error_line(printed):
    """Return the only line on standard error besides those of progress."""
    lines = printed.err.splitlines()
    (line,) = [line for line in lines if line.startswith("ringwear: ")]
    assert not [line for line in lines if "Traceback" in line]
    return line


@pytest.mark.parametrize("link", [False, True])
def test_a_foreign_picture_of_a_sweep_stays(command, tmp_path, link):
    """The sweep is refused before it computes anything.

    A picture of ringwear is replaced, but not the file that a link in its place points to.
    """
    (tmp_path / "map.toml").write_text(MAP)
    out, mine = tmp_path / "out", tmp_path / "mine.png"
    mine.write_bytes(b"mine")
    out.mkdir()
    picture = out / "sweep.png"
    if link:
        picture.symlink_to(mine)
    else:
        picture.write_bytes(b"mine")
    line = "sweep map.toml --out out --workers 1"
    assert "sweep.png" in error_line(command(line, 2))
    assert os.listdir(out) == ["sweep.png"]
    assert picture.read_bytes() == mine.read_bytes() == b"mine"
    picture.unlink()
    command(line)
    assert picture.stat().st_size > 1000
    # the picture is replaced by a link of the same name
    picture.unlink()
    picture.symlink_to(mine)
    command(f"{line} --resume")
    assert mine.read_bytes() == b"mine"
    assert picture.stat().st_size > 1000
    assert not picture.is_symlink()


@pytest.mark.parametrize("name", [".writing", ".complete"])
@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_foreign_folders_with_names_of_ringwear_stay(command, tmp_path, name, kind):
    out, there = tmp_path / "out", tmp_path / "out" / name
    out.mkdir()
    if kind == "folder":
        there.mkdir()
        (there / "notes.txt").write_text("mine")
    elif kind == "file":
        there.write_text("mine")
    else:
        (tmp_path / "elsewhere").mkdir()
        (tmp_path / "elsewhere" / "notes.txt").write_text("mine")
        there.symlink_to(tmp_path / "elsewhere")
    before = sorted(tmp_path.rglob("*"))
    assert name in error_line(command(DIRECT, 2))
    assert sorted(tmp_path.rglob("*")) == before
    # files of a killed run of ringwear are removed
    os.rename(there, tmp_path / "away")
    (out / ".writing").mkdir()
    (out / ".writing" / MARKER).write_text("{}")
    (out / ".writing" / "results.nc").write_text("half")
    command(DIRECT)
    assert {"results.nc", "summary.json", MARKER} == set(os.listdir(out))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_stop_while_files_are_moved_reports_that_they_are_in_place(
    command, tmp_path, monkeypatch, number
):
    replace = os.replace

    def interrupt(*paths):
        signal.raise_signal(number)
        replace(*paths)

    monkeypatch.setattr(os, "replace", interrupt)
    line = error_line(command(DIRECT, 1))
    assert "in place" in line
    assert "no incomplete files" not in line
    assert (tmp_path / "out" / "results.nc").exists()


def test_a_small_file_that_declares_huge_arrays_is_refused(command):
    """A file of eight megabytes that stands for 32 GB is not read."""
    with netCDF4.Dataset("large.nc", "w") as file:
        file.createDimension("time", 4_000_000_000)
        file.createVariable("indentation", float, ("time",), chunksizes=(2**20,), zlib=True)
    assert "32 GB" in error_line(command("check flat_punch large.nc", 2))


ENDLESS = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (6 * 2**30, 6 * 2**30))
from ringwear import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("line", ["run scene.toml", *nightly("sweep sweep.toml", "run /dev/zero")])
def test_an_endless_file_is_refused(script, tmp_path, line):
    """It is refused before it is read."""
    scene = Scene.load("flat_punch").table()
    scene["punch"]["profile"] = {"kind": "table", "file": "/dev/zero"}
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene))
    table = {"base": scene, "keep": ["indentation"], "axes": {"load.normal_force": [1.0, 2.0]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(table))
    done = script(ENDLESS, *line.split())
    assert done.returncode == 2
    (message,) = done.stderr.splitlines()
    assert "/dev/zero" in message
    assert "give a" in message
