"""Commands on systems that lack `fcntl`, `resource`, SIGHUP and copies of processes, as Windows."""

import pytest

COMMANDS = """
import os, signal, sys
# on Windows it needs none of these
import psutil
for name in ("fcntl", "resource"):
    sys.modules[name] = None
del os.fork, os.sysconf, signal.SIGHUP
import pandas as pd
import ringwear
from ringwear import SceneError, main
from ringwear.studies.crosscheck.result.output.folder import lock_folder
from pathlib import Path

quick = ["--methods", "mdr,direct", "--no-figures"]
assert main(["run", "flat_punch", "--out", "ran", *quick]) == 0
pd.DataFrame({"time": [0.0], "indentation": [1.0]}).to_csv("their.csv", index=False)
assert main(["check", "flat_punch", "their.csv", "--out", "checked"]) == 0
assert main(["deck", "flat_punch", "--for", "calculix", "--out", "deck"]) == 0
assert main(["study", "march", "--quick", "--out", "studied"]) == 0
result = ringwear.run("flat_punch", methods=["direct"])
result.save("saved")
assert repr(ringwear.load("saved")) == repr(result)
assert ringwear.load("ran").answers
sweep = ["--workers", "1", "--out", "swept"]
Path("sweep.toml").write_text(
    'base = "five_rings"\\nkeep = ["steady_rms_slope"]\\n[axes]\\n"punch.rings" = [2, 3]\\n'
)
assert main(["sweep", "sweep.toml", *sweep]) == 0
assert main(["sweep", "sweep.toml", *sweep, "--resume"]) == 0
with lock_folder(Path("ran")):
    assert main(["run", "flat_punch", "--out", "ran", *quick]) == 2
assert main(["run", "flat_punch", "--out", "ran", *quick]) == 0
assert not list(Path().rglob(".ringwear.lock"))
"""


@pytest.mark.slow
def test_commands_need_neither_locks_nor_limits_of_posix(script):
    done = script(COMMANDS)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "is being written to by another run" in done.stderr
    assert "Traceback" not in done.stderr
