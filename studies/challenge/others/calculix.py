"""Solve the five rings (problem 3) by a wear loop around CalculiX, on two meshes.

`ringwear deck` writes the half-space once. Each step prescribes displacements, reads CalculiX's
reaction forces, divides them by the area of each node to obtain pressures, and takes an explicit
step of Archard's law. A first run with a flat punch yields the stiffness, from which the
indentation under the force follows.
"""

import os
import re
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

PROBLEM, WEDGE = Path(__file__).parents[1] / "03_five_rings.toml", 180


def forces(folder, model, contact, depths):
    """Return the forces on the contact nodes that CalculiX computes at prescribed depths."""
    rows = [f"{node}, 2, 2, {-depth:.12g}" for node, depth in zip(contact, depths, strict=True)]
    step = ["*STEP", "*STATIC", "*BOUNDARY", *rows, "*NODE PRINT, NSET=CONTACT", "RF", "*END STEP"]
    (folder / "job.inp").write_text(model + "\n".join(step) + "\n")
    subprocess.run(["ccx", "job"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return -WEDGE * np.loadtxt(folder / "job.dat", skiprows=3)[:, 2]


for size, step in (0.4, 0.01), (0.25, 0.005):
    start = sum(os.times()[:4])
    with TemporaryDirectory() as name:
        folder = Path(name)
        flags = ["--element", "Q1", "--size", f"{size}", "--reach", "50", "--time", "0"]
        command = ["ringwear", "deck", str(PROBLEM), "--for", "calculix", *flags, "--out", name]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        model = (folder / "prescribed.inp").read_text().partition("*STEP")[0]
        node_list = re.search(r"NSET=CONTACT\n([^*]*)", model)[1]
        contact = [int(number) for number in node_list.replace(",", " ").split()]
        node_radii = dict(re.findall(r"^(\d+), ([^,]+), [^,]+, 0\.$", model, re.MULTILINE))
        radii = np.array([float(node_radii[str(node)]) for node in contact])
        ends = np.concatenate([[0], (radii[1:] + radii[:-1]) / 2, [1]])
        areas = np.diff(np.pi * ends**2)
        wear = np.where((5 * radii - 1e-9).astype(int) % 2, 10, 1)
        flat = forces(folder, model, contact, np.ones_like(radii))
        profile, rows = 0 * radii, []
        for number in range(round(2 / step) + 1):
            time = number * step
            worn = forces(folder, model, contact, profile) if number else 0 * flat
            depth = (2 + worn.sum()) / flat.sum()
            pressure = (depth * flat - worn) / areas
            if np.isclose(time, (0, 0.01, 0.1, 0.5, 2)).any():
                columns = time, radii, pressure, depth - profile, profile, depth
                rows.append(np.transpose(np.broadcast_arrays(*columns)))
            profile = profile + wear * pressure * step
    # leave out the ring edges, where the pressure jumps
    inside = np.abs(5 * radii - np.round(5 * radii)) > 1e-6
    rows = np.concatenate([row[inside] for row in rows])
    # processor time, here and in CalculiX
    seconds = sum(os.times()[:4]) - start
    head = f"# {seconds:.2f} s\ntime,radius,pressure,displacement,profile,indentation"
    file = Path(__file__).parent / f"03_calculix_{len(contact) - 1:03}.csv"
    np.savetxt(file, rows, "%.6g", ",", header=head, comments="")
    print(file.name, f"{seconds:.2f} s")
