"""Draw what programs of others err by against their seconds, beside methods of ours.

``python -m ringwear.studies.challenge.draw`` reads the files in `others`, whose names tell problem
and program, and whose first lines the seconds; it writes `errors.png` and prints the numbers.
"""

from collections import defaultdict
from pathlib import Path
from time import perf_counter

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ..figures.style import LOOKS
from ..problem.scene import Scene
from .certify import sample


def measure(scene: Scene, table: pd.DataFrame) -> tuple[float, float]:
    """Return the greatest relative errors over the times: of the indentation, and of the pressure
    as a root mean square over the radii.
    """
    exact = sample(scene, "bem", 1e-7).unstack()
    depth, true_depth = (of.indentation.groupby("time").max() for of in (table, exact))
    wrong, whole = (of.pressure.pow(2).groupby("time").sum() for of in (table - exact, exact))
    return (depth / true_depth - 1).abs().max(), (wrong / whole).max() ** 0.5


if __name__ == "__main__":
    folder, figure = Path(__file__).parent / "others", Figure((9, 6), layout="constrained")
    axes = figure.subplots(2, 3, sharex=True, sharey="row")
    for column, number in zip(axes.T, ("01", "03", "07"), strict=True):
        scene, rows = Scene.load(*folder.parent.glob(f"{number}*.toml")), defaultdict(list)
        for path in sorted(folder.glob(f"{number}*.csv")):
            table = pd.read_csv(path, comment="#").query("radius < 0.95")
            times, radii = (sorted(set(table[name])) for name in ("time", "radius"))
            scene = scene.changed(wear__times=times, output__radii=radii)
            errors = measure(scene, table.set_index(["time", "radius"]))
            rows[path.stem[3:-4]].append((float(path.read_text().split()[1]), *errors))
        for method in ("mdr", "fem"):
            sample(scene, method, 0.1)  # what is loaded once is not counted
            for digits in range(1, 7):
                start = perf_counter()
                table = sample(scene, method, 10.0**-digits).unstack()
                rows[method].append((perf_counter() - start, *measure(scene, table)))
        for program, measured in rows.items():
            seconds, *curves = np.transpose(measured)
            for quantity, axis, errors in zip(("d", "p"), column, curves, strict=True):
                looks = {"marker": "."} | LOOKS.get(program, {})
                axis.loglog(seconds, errors, label=program, **looks)
                axis.set(xlabel="seconds", ylabel=f"error of {quantity}")
                print(number, program, quantity, *map("{:.2g} s: {:.1e}".format, seconds, errors))
        column[0].legend(title=f"problem {number}", loc=(0.2, 1.02))
    figure.savefig(folder / "errors.png", dpi=110)
