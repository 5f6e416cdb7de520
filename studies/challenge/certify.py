"""Certify the numbers of the challenge: the digits in which independent methods agree.

``python -m ringwear.studies.challenge.certify`` computes all problems anew, in some minutes, and
writes `certified.csv`.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from ..crosscheck import Scene, run

# smallest rtol at which numbers are certified, by whether the punch is in full contact
FINEST_RTOL = {True: 1e-8, False: 1e-5}


def sample(scene: Scene, method: str, rtol: float) -> pd.Series:
    """Return the values of a method by time, radius (NaN if it has none) and quantity."""
    quantities = ["pressure", "profile", "displacement", "indentation", "normal_force"]
    dataset = run(Scene.of(scene, [method], rtol, quantities)).dataset
    tables = (
        dataset[name].to_dataframe("value").reset_index().assign(quantity=name)
        for name in quantities
        if name in dataset
    )
    return pd.concat(tables).set_index(["time", "radius", "quantity"])["value"]


def certify(scene: Scene) -> pd.DataFrame:
    """Return each value to the digits in which four runs agree, if these are two or more.

    The runs use three methods and different tolerances, so that meshes, cells and steps differ,
    too. The value is that of the finest run. The range of all values is at most half a unit of its
    last digit.

    Returns
    -------
    table : by time, radius and quantity, with the columns value (text) and digits
    """
    finest = FINEST_RTOL[scene.problem.full_contact]
    runs = ("mdr", finest), ("bem", 3 * finest), ("fem", 3 * finest), ("mdr", 10 * finest)
    values = [sample(scene, *method_and_rtol) for method_and_rtol in runs]
    sizes = (values[0].abs() / np.ptp(values, axis=0) / 2).clip(upper=1e12)  # at most twelve digits
    digits = np.log10(sizes[sizes >= 100]).astype(int)
    rounded = map("{:.{}e}".format, values[0][digits.index], digits - 1)
    return pd.DataFrame({"value": [*rounded], "digits": digits})


if __name__ == "__main__":
    here = Path(__file__).parent
    tables = {path.stem: certify(Scene.load(path)) for path in sorted(here.glob("[0-9]*.toml"))}
    pd.concat(tables, names=["problem"]).to_csv(here / "certified.csv")
