"""Compute Figs. 4 to 7 of the paper anew, and check its claims (`ringwear study paper`).

The punches are those of the paper; Poisson's ratio and the accuracy are those of the scene.
"""

import pandas as pd
import xarray
from matplotlib.figure import Figure

from ..crosscheck import AVERAGES, Scene, Source
from ..study.own import accept
from ..study.record import Record
from ..study.study import Study, remarks
from ..sweep.axes import Sweep
from ..sweep.sweep import sweep
from ..tables.writing import keeping_rows
from . import claims, figures
from .running_in import FiveRings
from .theory import FIG7_WEAR_RATIO, homogeneous, many_rings

QUICK_RTOL = 1e-3
"""Least tolerance of Figs. 5 to 7 in the quick study."""


def paper(
    scene: Source = "five_rings", *, quick: bool = False, record: Record | None = None
) -> Study:
    """Compute the figures of the paper, their data, and the table of its claims.

    Parameters
    ----------
    scene : a scene, of which Poisson's ratio and the accuracy count
    quick : whether to leave out punches of many rings and half of the points, and to solve with a
        tolerance of at least `QUICK_RTOL`
    record : collects the conclusions, also those of a study that is interrupted

    Raises
    ------
    SceneError
        if the scene does not fit the study
    """
    scene, record = accept("paper", scene), record or Record()
    drawn_figures = dict[str, Figure]()
    tables = dict[str, pd.DataFrame]()
    table, conclusions = pd.DataFrame(), list[str]()
    with keeping_rows(record.remarks):
        rtol = max(scene.accuracy.rtol, QUICK_RTOL) if quick else scene.accuracy.rtol
        solved = scene.changed(accuracy__rtol=rtol)
        five_rings = FiveRings(solved)
        states, history = five_rings.states, five_rings.history
        conclusions.append(
            f"Figs. 4, 5 by {', '.join(states.solver.values)}: 70 % of the displacement difference "
            f"is reached after {float(states.time[4]):.1%} of t_stat"
        )
        drawn_figures["fig4"] = figures.draw_states(states)
        fields = states[["least_wear_over_d0", "f_over_d0", "g_over_d0", "p_over_p0"]]
        tables["fig4"] = fields.to_dataframe().reset_index()
        drawn_figures["fig5"] = figures.draw_history(states, history)
        tables["fig5"] = history.to_dataframe("gradient").reset_index()
        curves = {}
        for number in (6, 7):
            counts = (2, 4, 8) if quick else (2, 4, 8, 16, 32, 64)
            curves[number] = compute_gradients(number, solved, counts, 50 if quick else 25)
            drawn_figures[f"fig{number}"] = figures.draw_gradients(number, curves[number])
            tables[f"fig{number}"] = curves[number].to_dataframe().reset_index()
            difference = float(abs(curves[number].fem / curves[number].direct - 1).max())
            conclusions.append(
                f"Fig. {number}: finite elements differ from direct integration by at most "
                f"{difference:.0e}"
            )
        table = claims.tabulate_claims(states, history, curves[6], curves[7])
        conclusions += claims.conclusions_of_claims(table)
    tables["claims"] = table
    return Study(
        "paper",
        scene,
        table,
        conclusions=(*conclusions, *remarks(record, quick)),
        figures=drawn_figures,
        tables=tables,
    )


def compute_gradients(
    figure: int, scene: Scene, counts: tuple[int, ...], spacing: int
) -> xarray.Dataset:
    """Return the data of Fig. 6 or 7, computed by the bundled sweep `fig6` or `fig7`.

    Parameters
    ----------
    figure : 6 or 7
    scene : scene with the Poisson's ratio and the accuracy of finite elements
    counts : numbers of rings
    spacing : number of points from one that finite elements compute to the next, a multiple of 25;
        direct integration computes 25 from one to the next

    Returns
    -------
    xarray.Dataset
        Normalised gradients `direct` and `fem` over (ratio, rings, gradient_average), and the limit
        of many rings `limit` over (gradient_average, ratio). `fem` is computed at some points and
        NaN elsewhere.
    """
    bundled = Sweep.load(f"fig{figure}")
    base, axes = bundled.table["base"], bundled.table["axes"] | {"punch.rings": list(counts)}
    varied_key = ("punch.wear_ratio", "punch.width_ratio")[figure - 6]
    ratio_name, values = varied_key.removeprefix("punch."), bundled.columns[varied_key].values
    by_direct = sweep(base, axes | {varied_key: values[:: spacing // 25]}, keep=bundled.keep)
    fem_points = {
        varied_key: values[::spacing],
        "punch.rings": [count for count in counts if count <= 16],
    }
    by_fem = sweep(
        base
        | {
            "methods": ["fem"],
            "half_space": base["half_space"] | {"poisson_ratio": scene.half_space.poisson_ratio},
            "accuracy": {"rtol": scene.accuracy.rtol},
        },
        axes | fem_points,
        keep=bundled.keep,
    )
    homogeneous_gradient = xarray.DataArray(homogeneous(), {"gradient_average": list(AVERAGES)})
    curves = xarray.Dataset(
        {
            name: slopes.steady_rms_slope.sel(solver=name, drop=True) / homogeneous_gradient
            for name, slopes in (("direct", by_direct), ("fem", by_fem))
        }
    ).rename({ratio_name: "ratio"})
    ratios = curves.ratio.values
    limit = many_rings(ratios, 1.0) if figure == 6 else many_rings(FIG7_WEAR_RATIO, ratios)
    return curves.assign(limit=(("gradient_average", "ratio"), limit))
