"""Certify the numbers of the challenge: those digits that independent methods agree in.

``python -m ringwear.studies.challenge.certify`` computes all problems anew, in some minutes, and
writes `certified.csv`.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from ..outcome.run import run
from ..scene.scene import Scene


def sample(scene: Scene, method: str, rtol: float) -> pd.Series:
    """Return values of a method by time, radius (NaN where of none) and quantity."""
    wanted = ["pressure", "profile", "displacement", "indentation", "normal_force"]
    dataset = run(Scene.of(scene, [method], rtol, wanted)).dataset
    tables = (
        dataset[name].to_dataframe("value").reset_index().assign(quantity=name)
        for name in wanted
        if name in dataset
    )
    return pd.concat(tables).set_index(["time", "radius", "quantity"])["value"]


def certify(scene: Scene) -> pd.DataFrame:
    """Return the digits of each value that four runs agree in, if they are two or more.

    Three methods, at different accuracies: their meshes, cells and steps differ, too. The value is
    that of the finest run; the greatest difference to another is at most half a unit of the last
    digit.
    """
    finest = scene.problem.contact.finest_rtol
    settings = ("mdr", finest), ("bem", 3 * finest), ("fem", 3 * finest), ("mdr", 10 * finest)
    values = [sample(scene, *chosen) for chosen in settings]
    sizes = (values[0].abs() / np.ptp(values, axis=0) / 2).clip(upper=1e12)  # to twelve digits
    digits = np.log10(sizes[sizes >= 100]).astype(int)
    rounded = map("{:.{}e}".format, values[0][digits.index], digits - 1)
    return pd.DataFrame({"value": [*rounded], "digits": digits})


if __name__ == "__main__":
    here = Path(__file__).parent
    tables = {path.stem: certify(Scene.load(path)) for path in sorted(here.glob("[0-9]*.toml"))}
    pd.concat(tables, names=["problem"]).to_csv(here / "certified.csv")
