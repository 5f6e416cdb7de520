"""Terminals, pipes and signals that end a command: its files stay, and it ends with one line."""

import os
import shlex
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest
import tomli_w
from groups import nightly

from ringwear import Scene, load, main

RINGWEAR = shlex.join([sys.executable, "-m", "ringwear.studies.cli"])
RUN = "run flat_punch --methods direct --no-figures --out out"
FULL = "No space left on device"
# redirections, the exit status, and words on standard error if it can be read
STREAMS = [
    ("> /dev/full", 1, f"standard output could not be written: {FULL}"),
    ("2> /dev/full", 0, ""),
    ("> /dev/full 2> /dev/full", 1, ""),
    (">&-", 0, ""),
    ("2>&-", 0, ""),
    ("<&- >&- 2>&-", 0, ""),
    ("| true", 0, ""),
]


def shell(command, folder, **options):
    """Run a command by a shell, whose status is that of the first command of a pipe."""
    call = ["bash", "-c", f"{RINGWEAR} {command}; exit ${{PIPESTATUS[0]}}"]
    return subprocess.run(call, cwd=folder, text=True, capture_output=True, timeout=120, **options)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("streams", "status", "words"),
    [STREAMS[0], *nightly(*STREAMS[1:])],
)
def test_results_are_written_whatever_happens_to_the_streams(streams, status, words, tmp_path):
    done = shell(f"{RUN} {streams}", tmp_path)
    assert done.returncode == status
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    steady_rate = load(tmp_path / "out")["steady_wear_rate"]
    # k F v / (pi a^2)
    assert float(steady_rate[0]) == pytest.approx(2 / 3.141592653589793, rel=1e-12)
    if status:
        messages = [line for line in done.stderr.splitlines() if line.startswith("ringwear: ")]
        assert len(messages) == (1 if words else 0)


COMMANDS = {
    "check": ("check flat_punch their.csv", {"check.csv", "report.html", "results.nc"}),
    "deck": ("deck flat_punch --for calculix --size 0.5", {"contact_1.inp", "README.md"}),
    "mesh": ("mesh flat_punch", {"mesh.vtu", "mesh.png"}),
    "fit": ("fit flat_punch data.csv --parameters punch.wear_coefficients", {"estimates.csv"}),
    "study": ("study truncation flat_punch --quick", {"truncation.csv", "report.html"}),
    "compare": ("compare direct.toml direct.toml", {"answers.csv"}),
    "sweep": ("sweep sweep.toml", {"sweep.png", "sweep.zarr"}),
}


@pytest.mark.nightly
@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_loses_its_files(name, tmp_path, monkeypatch):
    command, files = COMMANDS[name]
    scene = Scene.load("flat_punch").changed(methods=["direct"])
    (tmp_path / "direct.toml").write_text(scene.to_toml(), "utf-8")
    sweep = {"base": scene.table(), "axes": {"load.normal_force": [1.0, 2.0, 3.0]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    (tmp_path / "their.csv").write_text("time,indentation\n0,1.0\n", "utf-8")
    # d(t) of a flat punch, to three digits
    rows = ["0.1,1.068", "0.3,1.2", "0.6,1.389", "1,1.639", "2,2.264"]
    (tmp_path / "data.csv").write_text("\n".join(["time,indentation", *rows]), "utf-8")
    full = shell(f"{command} --out out > /dev/full 2> /dev/full", tmp_path)
    assert full.returncode in (1, 3)
    names = {entry.name for entry in (tmp_path / "out").iterdir()}
    assert files <= names
    assert not names & {".writing", ".complete"}
    # the status is that of the results if they can be printed
    monkeypatch.chdir(tmp_path)
    printed = main([*command.split(), "--out", "again"])
    assert printed == (full.returncode if full.returncode == 3 else 0)


@pytest.mark.slow
def test_characters_that_an_encoding_does_not_have_are_written_as_escape_sequences(tmp_path):
    title = Scene.load("flat_punch").changed(title="Kugel ø 5 µm", methods=["direct"])
    (tmp_path / "mine.toml").write_text(title.to_toml(), "utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = shell("run mine.toml --no-figures --out out", tmp_path, env=environment)
    assert done.returncode == 0
    assert r"Kugel \xf8 5 \xb5m" in done.stdout
    assert (tmp_path / "out" / "results.nc").exists()


WAITING = """
import logging, sys, time
from ringwear import main

class Wait(logging.Handler):
    def emit(self, record):
        if "level 2" in record.getMessage():
            time.sleep(3)

logging.getLogger("ringwear").addHandler(Wait())
sys.exit(main(["study", "march", "--quick", "--out", sys.argv[1]]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("ignored", [False, *nightly(True)])
def test_a_study_keeps_its_rows_when_its_terminal_is_closed(ignored, tmp_path):
    """SIGHUP ends it like SIGTERM, unless `nohup` ignores the signal; the terminal is gone then."""
    out = tmp_path / "out"
    controller, terminal = os.openpty()
    call = [*(["nohup"] if ignored else []), sys.executable, "-c", WAITING, str(out)]
    with subprocess.Popen(
        call, stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal, cwd=tmp_path
    ) as study:
        os.close(terminal)
        table = out / ".writing" / "march.csv"
        # the headings and the rows of the first level
        while not (table.exists() and table.read_text("utf-8").count("\n") > 1):
            assert study.poll() is None
            time.sleep(0.02)
        os.close(controller)
        study.send_signal(signal.SIGHUP)
    # `nohup` also sends the output to a file
    assert study.returncode == (0 if ignored else 1)
    rows = pd.read_csv(out / "march.csv")
    levels = len(rows[["way", "level"]].drop_duplicates())
    assert levels > 1 if ignored else levels == 1
    page = (out / "report.html").read_text("utf-8")
    assert ("INTERRUPTED" in page) == (not ignored)
    assert not (out / ".writing").exists()


def test_streams_are_restored(capsys):
    """A script that calls the command line has its own streams afterwards."""
    streams = sys.stdout, sys.stderr
    assert main(["scenes"]) == 0
    assert main(["run", "absent"]) == 2
    assert (sys.stdout, sys.stderr) == streams
    assert "five_rings" in capsys.readouterr().out


# a process that is interrupted at the moment at which a module is about to be loaded
INTERRUPTED_IMPORT = """
import signal, sys

class Interruption:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)

# where the tests themselves run in the background, the shell has told them to ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interruption())
from ringwear import main
sys.exit(main(["run", "flat_punch", "--rtol", "1e-2", "--out", sys.argv[2]]))
"""
MODULES = [
    "numpy",
    *nightly("pydantic", "argparse", "scipy.linalg", "skfem", "netCDF4", "matplotlib"),
    *nightly("ringwear.studies.crosscheck.scene.scene", "ringwear.studies.report.page"),
]


@pytest.mark.parametrize("module", MODULES)
def test_an_interruption_while_modules_are_loaded_is_one_line(module, script, tmp_path):
    done = script(INTERRUPTED_IMPORT, module, "out")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "ringwear: stopped; no incomplete files are left"
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


LATER = """
import signal, sys
from ringwear import main
from ringwear.studies.crosscheck.result import run

def fail(*_, **__):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("a library could not be loaded")

signal.signal(signal.SIGINT, signal.default_int_handler)
run.begun = fail
sys.exit(main(["run", "flat_punch", "--out", sys.argv[1]]))
"""


@pytest.mark.slow
def test_an_interruption_that_a_library_turns_into_an_error_is_one_line(script, tmp_path):
    done = script(LATER, "out")
    assert done.returncode == 1
    assert done.stderr == "ringwear: stopped; no incomplete files are left\n"
    assert not (tmp_path / "out").exists()
