"""Saved results are read back as they were, or refused in one sentence: never altered or mixed.

Checksums in `summary.json` cover each array of `results.nc` and each other entry.
"""

import json
import random
import shutil
from dataclasses import replace

import netCDF4
import numpy as np
import pytest
import xarray

from ringwear import RingwearError, Scene, SceneError, load, main, run
from ringwear.studies.crosscheck.result.output import files

FILES = ("results.nc", "summary.json")
SCENE = Scene.load("five_rings").changed(methods=["mdr", "direct"], accuracy__rtol=1e-2)


@pytest.fixture(scope="module")
def result():
    return run(SCENE)


@pytest.fixture(scope="module")
def saved(result, tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved")
    result.save(folder)
    return folder


@pytest.fixture(scope="module")
def of_twice_the_force(tmp_path_factory):
    folder = tmp_path_factory.mktemp("twice")
    run_into(folder, SCENE.changed(load__normal_force=4.0))
    return folder


@pytest.fixture
def copied(saved, tmp_path):
    """Return a copy of the saved results, which a test may change."""
    return shutil.copytree(saved, tmp_path / "copied")


def edit_summary(folder, change):
    """Let a function change the content of `summary.json` or return another one."""
    entries = json.loads((folder / "summary.json").read_text("utf-8"))
    changed = change(entries)
    text = json.dumps(entries if changed is None else changed)
    (folder / "summary.json").write_text(text, "utf-8")


def run_into(folder, scene):
    """Run a scene by the command, and write the numbers without figures into a folder."""
    file = folder.with_suffix(".toml")
    file.write_text(scene.to_toml(), "utf-8")
    assert main(["run", str(file), "--no-figures", "--no-report", "--out", str(folder)]) == 0


def refusal(folder):
    """Return the error message for a folder that is refused: one sentence with a remedy."""
    with pytest.raises(SceneError) as error:
        load(folder)
    message = str(error.value)
    assert "\n" not in message
    assert message.startswith(f"{folder} cannot be read as results of ringwear: ")
    assert message.count("; ") == 1
    return message


def read_or_refusal(folder):
    """Return the results in a folder and an empty text, or None and the refusal in one line."""
    try:
        return load(folder), ""
    except RingwearError as error:
        message = str(error)
    assert message
    assert "\n" not in message
    return None, message


def test_saved_results_are_read_back_exactly(result, saved):
    read = load(saved)
    assert type(read.dataset) is xarray.Dataset
    assert read.dataset.identical(result.dataset)
    # xarray alone reads the same arrays and attributes
    of_xarray = xarray.load_dataset(saved / "results.nc")
    assert set(of_xarray.variables) == set(result.dataset.variables)
    for name, array in of_xarray.variables.items():
        xarray.testing.assert_identical(array, result.dataset[name].variable)
    assert read.summary == json.loads(json.dumps(result.summary))
    assert repr(read) == repr(result)


# an array, and what happens to it on its way into the file
ALTERATIONS = {
    "one bit": ("time", lambda of: of._replace(values=of.values * np.nextafter(1.0, 2.0))),
    "another unit": ("indentation", lambda of: of._replace(attrs=of.attrs | {"units": "mm"})),
    "methods exchanged": ("solver", lambda of: of._replace(values=of.values[::-1])),
}


@pytest.mark.parametrize("alteration", ALTERATIONS)
def test_an_array_that_is_altered_while_it_is_written_is_noticed(
    alteration, result, tmp_path, monkeypatch
):
    name, alter = ALTERATIONS[alteration]
    write = files.write_table

    def write_altered(table, path):
        data_vars, coords = (
            {key: alter(array) if key == name else array for key, array in part.items()}
            for part in (table.data_vars, table.coords)
        )
        write(replace(table, data_vars=data_vars, coords=coords), path)

    monkeypatch.setattr(files, "write_table", write_altered)
    with pytest.raises(RingwearError, match=r"results\.nc was not written correctly"):
        files.write_numbers(result.table, result.summary, tmp_path)


def test_an_answer_that_is_altered_while_it_is_written_is_noticed(result, tmp_path):
    summary = json.loads(json.dumps(result.summary))
    summary["answer"]["mdr"]["indentation_start"] *= 1.01
    with pytest.raises(RingwearError, match=r"summary\.json was not .*: indentation_start"):
        files.write_numbers(result.table, summary, tmp_path)


def test_an_entry_that_is_altered_is_refused(copied):
    edit_summary(copied, lambda entries: entries.update(verdict="disagree"))
    assert "summary.json is not as it was written" in refusal(copied)


@pytest.mark.parametrize("name", FILES)
def test_files_of_two_runs_are_not_mixed(name, copied, of_twice_the_force):
    shutil.copy(of_twice_the_force / name, copied / name)
    assert "results.nc is not as it was written" in refusal(copied)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_refused(name, copied, result):
    """Bits are flipped, parts overwritten and ends cut off, at places drawn at random."""
    draw, content = random.Random(5), (copied / name).read_bytes()
    refused = 0
    for number in range(45):
        damaged, place = bytearray(content), draw.randrange(len(content))
        if number % 3 == 0:
            damaged[place] ^= 1 << draw.randrange(8)
        elif number % 3 == 1:
            damaged[place : place + 16] = draw.randbytes(16)
        else:
            del damaged[place:]
        (copied / name).write_bytes(damaged)
        read, refusal_of_it = read_or_refusal(copied)
        if refusal_of_it:
            refused += 1
            continue
        assert read.dataset.identical(result.dataset)
        assert read.summary == json.loads(json.dumps(result.summary))
    # a part of a netCDF file is unused, and blanks in JSON may be cut off
    assert refused >= 38


DEEP = 100_000


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "no checksums"),
        ("", "Expecting value"),
        ("[" * DEEP, "recursion"),
        ('{"checksums": {"variables": {}}}', "no checksums of both files"),
        ('{"a": ' + "9" * 5000 + "}", "digits"),
    ],
)
def test_a_summary_that_is_none_is_refused(text, words, copied):
    (copied / "summary.json").write_text(text, "utf-8")
    assert words in refusal(copied)


@pytest.mark.parametrize("name", FILES)
def test_a_missing_file_or_a_folder_in_its_place_is_refused(name, copied):
    (copied / name).unlink()
    assert f"it has no {name}" in refusal(copied)
    (copied / name).mkdir()
    assert name in refusal(copied) or "directory" in refusal(copied)


@pytest.mark.parametrize(
    "line", ["compare copied flat_punch", "check flat_punch copied/results.nc"]
)
def test_commands_refuse_altered_results(line, copied, command, tmp_path):
    with netCDF4.Dataset(copied / "results.nc", "a") as file:
        file["indentation"][:] *= 1.01
    (message,) = command(line, 2).err.splitlines()
    assert "results.nc is not as it was written; run its scene again" in message
    assert not (tmp_path / "results").exists()


def test_a_folder_whose_files_were_not_all_moved_is_refused(copied, result):
    """Between two moves of a run that was killed, the new files are in `.complete`."""
    (copied / ".complete").mkdir()
    for name in ("summary.json", ".ringwear.json"):
        (copied / name).rename(copied / ".complete" / name)
    assert ".complete has the " in refusal(copied)
    run_into(copied, SCENE)
    assert load(copied).dataset.identical(result.dataset)
