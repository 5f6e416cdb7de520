"""Messages name only options that the command has."""

import re
from pathlib import Path

import pytest
from groups import nightly_but

from ringwear import main
from ringwear.studies.arguments import COMMANDS
from ringwear.studies.named_studies import STUDIES

ROOT = Path(__file__).parents[2]
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
PIN = """
units = "SI"
methods = ["mdr"]
[punch]
radius = 1.0
wear_coefficient = 1e-9
profile = { kind = "ball", ball_radius = 10.0 }
[half_space]
plane_strain_modulus = 1e6
[load]
normal_force = 1.0
sliding_speed = 1.0
[wear]
times = [0.0, 1.0]
"""
FAULTY = [
    "",
    "0,1\n1,2\n",
    "radius,pressure\n0.5,1\n",
    "time,pressure\n0,1\n",
    "time,displacement\n0,1\n",
    "time,radius,presure\n0,0.5,1\n",
    "time,time,indentation\n0,0,1\n",
    "time,radius,p,contact_pressure\n0,0.5,1,1\n",
    "time,radius,pressure\n0,0.5,high\n",
    "time,radius,pressure\n0,5,1\n0,6,1\n",
    "time,radius,pressure\n0,0.5,1\n0,6000,1\n",
    "time,radius,p_0,p_1\n0,0.5,1,1\n",
    "time [m],radius [s],pressure [mPa]\n0,0.5,1\n",
    "time,indentation [mPa]\n0,0.5\n1,.6\n",
    "cycles,indentation\n0,1\n1,2\n",
    "time,lost_mass\n0,0\n1,2\n",
    "time,indentation\n0,2\n1,1\n2,.5\n",
    "indentation\n1\n2\n",
    "h,u\n1,2\n",
    "h,u\n1/2,x\n1/4,1\n",
    "x (um),z\n0,1\n1,2\n",
    "x,z,x,z\n0,1,0,1\n",
    "<?xml version='1.0'?>\n<VTKFile>\n",
    "{'a': 1}",
    '{"a": 1}',
]
VTU = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="1">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1000 0 0 0 -1000 0
</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray>
<DataArray type="Int64" Name="types" format="ascii">5</DataArray></Cells>
<PointData><DataArray type="Float64" Name="disp_y" format="ascii">1 1 0</DataArray></PointData>
</Piece></UnstructuredGrid></VTKFile>
"""
GOOD_SCANS = ("0,1\n1,2\n", "cycles,", "time,lost_mass", "time,indentation\n0,2\n1,1\n2,.5\n")
"""Beginnings of files that a scan may have: they are no fault, and what is run takes long."""
FILES = [*((content, ".csv") for content in FAULTY), (VTU, ".vtu"), ("no deck", ".inp")]
CALLS = {
    "check": "check scene.toml {file}",
    "fit": "fit scene.toml {file} --parameters punch.wear_coefficient",
    "orders": "orders {file} --by h",
    "challenge": "challenge 03 {file}",
    "plan": "plan scene.toml --mesh {file}",
    "study refinement": "study refinement scene.toml --quick --mesh {file}",
    "run": "run scan.toml --no-figures",
    "sweep": "sweep sweep.toml",
    "deck": "deck scan.toml --for abaqus",
    "mesh": "mesh scan.toml",
}


def options_of(command, name):
    return {*FLAG.findall(command(f"{name} --help").out)}


@pytest.mark.parametrize("name", nightly_but(("check", "fit", "orders", "challenge"), CALLS))
def test_messages_name_only_options_of_the_command(name, command, capsys):
    options = options_of(command, name)
    Path("scene.toml").write_text(PIN, "utf-8")
    refused, good = 0, {"fit": (), "orders": (), "check": GOOD_SCANS[3:]}.get(name, GOOD_SCANS)
    for number, (content, ending) in enumerate(FILES):
        if content.startswith(good):
            continue
        file = f"theirs{number}{ending}"
        Path(file).write_text(content, "utf-8")
        profile = f'profile = {{ kind = "table", file = "{file}" }}'
        Path("scan.toml").write_text(re.sub("profile = .*", profile, PIN), "utf-8")
        axes = '[axes]\n"load.normal_force" = [1.0, 2.0]\n'
        Path("sweep.toml").write_text(f'base = "scan.toml"\n{axes}', "utf-8")
        out = f" --out out{number}" if "--out" in options else ""
        refused += main(f"{CALLS[name]}{out}".format(file=file).split()) == 2
        # a whole command may be named, as in `ringwear plan SCENE --size H`
        shown = re.sub(r"ringwear [a-z]+ [A-Z]+[^;:`]*", "", capsys.readouterr().err)
        assert {*FLAG.findall(shown)} <= options, shown
    assert refused > len(FILES) / 2


def test_every_option_that_the_sources_name_exists(command):
    commands = [name for name in COMMANDS if name != "study"]
    commands += [f"study {name}" for name in STUDIES]
    options = set().union(*(options_of(command, name) for name in commands))
    for folder in ("studies", "fem", "mdr", "meshes"):
        for file in (ROOT / folder).rglob("*.py"):
            named = {*FLAG.findall(file.read_text("utf-8"))}
            assert named <= {*options, "--version"}, file
