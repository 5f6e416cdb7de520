"""A finished map in a page.

How many scenes failed and why, where methods disagree most, and how honest their errors are.
"""

from collections import Counter
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array
from .axes import Sweep, described
from .layout import DONE, FAILED, PENDING

# the commonest reasons of failures that are listed
REASONS = 10


def summary(dataset: xarray.Dataset, sweep: Sweep) -> dict[str, Any]:
    """Numbers of scenes, the commonest reasons of failures, greatest disagreement and least
    effectivity, each with where.
    """
    status = dataset["status"].values
    found: dict[str, Any] = {
        "scenes": sweep.count,
        "finished": int(np.sum(status == DONE)),
        "failed": int(np.sum(status == FAILED)),
        "reasons": _reasons(dataset, FAILED),
        "reasons_pending": _reasons(dataset, PENDING),
        "sweep": sweep.table,
    }
    conclusions = []
    if "disagreement" in dataset and np.isfinite(values := dataset["disagreement"].values).any():
        greatest, where = _greatest(values, sweep)
        found["greatest_disagreement"] = {"over_uncertainty": greatest, "scene": where}
        found["disagreeing"] = int(np.sum(values > 1))
        conclusions.append(
            f"methods disagree in {found['disagreeing']} scenes; greatest difference over its "
            "uncertainty: "
            f"{greatest:.2g}, at {where}"
        )
    if "effectivity" in dataset and np.isfinite(values := dataset["effectivity"].values).any():
        least, where = _greatest(-values, sweep)
        found["least_effectivity"] = {"stated_over_error": -least, "scene": where}
        conclusions.append(
            "least error stated, over the one that a far more accurate method shows: "
            f"{-least:.2g}, at {where}"
        )
    return found | {"conclusions": conclusions}


def _reasons(dataset: xarray.Dataset, status: int) -> dict[str, int]:
    """The commonest reasons of scenes with such a status, and how many have them."""
    texts = dataset["reason"].values[dataset["status"].values == status]
    return dict(Counter(str(text) for text in texts if text).most_common(REASONS))


def _greatest(values: Array, sweep: Sweep) -> tuple[float, str]:
    at = np.unravel_index(int(np.nanargmax(values)), values.shape)
    return float(values[at]), described(sweep.changes(tuple(int(place) for place in at)))
