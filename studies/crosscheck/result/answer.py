"""The answer of a run: the numbers that describe the punch, by each method."""

from typing import TYPE_CHECKING

import numpy as np

from ....meshes.radial import Array
from ..problem.quantities import ANSWER, error_name

if TYPE_CHECKING:
    import xarray

# the numbers of the answer, and quantities that are reported together with them
REPORTED = (*ANSWER, "steady_wear_rate", "steady_rms_slope")


class Answers(dict[str, dict[str, Array]]):
    """The numbers of the answer, by method; an unknown key is answered with a known one."""

    @classmethod
    def of(cls, dataset: "xarray.Dataset") -> "Answers":
        """Return the numbers in a dataset and their errors; NaN if a method or a scene has none."""
        names = [*REPORTED, *map(error_name, REPORTED)]
        arrays = {name: dataset[name].values for name in names if name in dataset}
        return cls(
            {
                str(solver): {
                    name: arrays[name][row] if name in arrays else np.asarray(np.nan)
                    for name in names
                }
                for row, solver in enumerate(dataset["solver"].values)
            }
        )

    def __missing__(self, key: object) -> dict[str, Array]:
        """Raise a KeyError that says what to write instead."""
        first = next(iter(self), "mdr")
        number = key if key in self.get(first, {}) else "time_to_90"
        raise KeyError(
            f"no method {key!r} in these answers: write answers[{first!r}][{number!r}]; the "
            f"methods are {', '.join(self)}"
        )
