"""Draw what programs of others err by against their seconds, beside methods of ours.

``python -m ringwear.studies.challenge.draw`` reads the files in `others`, whose names tell problem
and program, and whose first lines the seconds; it writes `errors.png` and prints the numbers.
Seconds of ours are the processor's.
"""

from pathlib import Path
from time import process_time

import pandas as pd
import xarray
from matplotlib.figure import Figure

from ..check.check import check
from ..figures.style import LOOKS
from ..outcome.run import run
from ..problem.scene import Scene

ERRORS = ["indentation", "pressure"]


def measure(
    scene: Scene, program: str, seconds: float, results: pd.DataFrame | xarray.Dataset
) -> pd.DataFrame:
    """Return a row: a program, its seconds, and its greatest errors over the times."""
    exact = scene.changed(accuracy__rtol=1e-7)
    verdicts = pd.DataFrame(check(exact, {"theirs": results}, methods=["bem"]).verdicts)
    errors = verdicts["error"].abs().groupby(verdicts["quantity"]).max()[ERRORS]
    return pd.DataFrame({"program": [program], "seconds": seconds, **errors})


def measure_all(scene: Scene, files: list[Path]) -> pd.DataFrame:
    """Return rows of programs of others, by their files, and of ours at their times and radii."""
    rows, methods = [], ["mdr", "fem"]
    for path in files:
        table = pd.read_csv(path, comment="#").query("radius < 0.95")
        seconds = float(path.read_text().split()[1])
        rows.append(measure(scene, path.stem[3:-4], seconds, table))
    times, radii = (table[name].unique().tolist() for name in ("time", "radius"))
    scene = scene.changed(wear__times=times, output__radii=radii, output__quantities=ERRORS)
    # what is loaded once is not counted
    measure(scene, "", 0.0, run(scene, methods).dataset)
    for method in methods:
        for digits in range(1, 7):
            start = process_time()
            dataset = run(scene.changed(accuracy__rtol=10.0**-digits), [method]).dataset
            rows.append(measure(scene, method, process_time() - start, dataset))
    return pd.concat(rows)


if __name__ == "__main__":
    folder, figure = Path(__file__).parent / "others", Figure((9, 6), layout="constrained")
    axes = figure.subplots(2, 3, sharex=True, sharey="row")
    for column, number in zip(axes.T, ("01", "03", "07"), strict=True):
        scene = Scene.load(*folder.parent.glob(f"{number}*.toml"))
        table = measure_all(scene, sorted(folder.glob(f"{number}*.csv")))
        print(f"problem {number}", table.to_string(index=False, float_format="{:.2g}".format))
        for program, rows in table.groupby("program", sort=False):
            looks = {"marker": ".", "label": program} | LOOKS.get(str(program), {})
            for quantity, panel in zip(ERRORS, column, strict=True):
                panel.loglog(rows["seconds"], rows[quantity], **looks)
                panel.set(xlabel="seconds", ylabel=f"error of {quantity}")
        column[0].legend(title=f"problem {number}", loc=(0.2, 1.02))
    figure.savefig(folder / "errors.png", dpi=110)
