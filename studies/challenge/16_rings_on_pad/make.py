"""Certify the answers of problem 16: MDR and finite elements.

``python -m ringwear.studies.challenge.16_rings_on_pad.make`` writes `answers.csv` in some seconds.
The finite elements end at a clamped boundary, where fields on a rigid base have decayed. Both
methods share the law of wear, but no formula of the ground.
"""

from collections.abc import Iterator
from pathlib import Path

from ...crosscheck import Scene, run
from ..answers import write_answers

FOLDER = Path(__file__).parent
RTOL = {"mdr": 1e-9, "fem": 1e-8}
UNITS = {"indentation": "a", "pressure": "E*", "profile": "a"}


def values() -> Iterator[dict[str, object]]:
    """Yield a row with both values for each time, radius and quantity.

    The slowest relaxation time has neither a time nor a radius. Profiles are left out at the start,
    when nothing is worn.
    """
    scene = Scene.load(FOLDER / "scene.toml").changed({"accuracy.fem.far_field": "fixed"})
    first, second = (
        run(scene.changed(accuracy__rtol=rtol), methods=[method]).dataset.isel(solver=0)
        for method, rtol in RTOL.items()
    )
    methods = {"methods": " and ".join(RTOL)}
    slowest = [float(dataset["relaxation_time"][0]) for dataset in (first, second)]
    yield _row({}, "relaxation_time", slowest, "a / (E* k v)") | methods
    for time in first["time"].to_numpy():
        for quantity, unit in UNITS.items():
            if quantity == "profile" and time == 0:
                continue
            pair = [dataset[quantity].sel(time=time) for dataset in (first, second)]
            for radius in first["radius"].to_numpy() if "radius" in pair[0].dims else [None]:
                at = {} if radius is None else {"radius": radius}
                both = [float(values.sel(at)) for values in pair]
                yield _row({"time": time} | at, quantity, both, unit) | methods


def _row(place: dict[str, float], quantity: str, pair: list[float], unit: str) -> dict[str, object]:
    time, radius = place.get("time"), place.get("radius")
    both = {"first": pair[0], "second": pair[1]}
    return {"time": time, "radius": radius, "quantity": quantity, **both, "unit": unit}


if __name__ == "__main__":
    write_answers(FOLDER, values())
