"""The whole paper again: Figs. 4 to 7, and every claim checked (`ringwear study paper`).

The punches are the paper's; half-space and accuracy are those of the scene.
"""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from ..problem.scene import Scene
from ..tables import keeping_rows
from . import claims, figures
from .gradients import compute_gradients
from .running_in import FiveRings, compute_relaxation_times


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Write the figure asked for, or without `--fig` all of them and the table of claims."""
    problem, quick = scene.problem, options.quick
    wanted = {options.fig} if options.fig else {4, 5, 6, 7}
    conclusions: list[str] = []
    # the matrices are small: threads would only wait on each other
    with threadpool_limits(1), keeping_rows(conclusions):
        if wanted & {4, 5}:
            five = FiveRings(problem)
            conclusions.append(
                f"Figs. 4, 5: {', '.join(five.evolutions)}; 70 % of the displacement difference "
                f"after {float(five.states.time[4]):.1%} of t_stat"
            )
        if 4 in wanted:
            figures.draw_states(five, out / "fig4.png")
            fields = five.states[["least_wear_over_d0", "f_over_d0", "g_over_d0", "p_over_p0"]]
            fields.to_dataframe().to_csv(out / "fig4.csv")
        if 5 in wanted:
            figures.draw_history(five, out / "fig5.png")
            five.history.gradient.to_dataframe().to_csv(out / "fig5.csv")
        curves = {}
        for number in sorted(wanted & {6, 7}):
            counts = (2, 4, 8) if quick else (2, 4, 8, 16, 32, 64)
            curves[number] = compute_gradients(number, problem, counts)
            figures.draw_gradients(number, curves[number], out / f"fig{number}.png")
            curves[number].to_dataframe().to_csv(out / f"fig{number}.csv")
            difference = float(abs(curves[number].fem / curves[number].direct - 1).max())
            conclusions.append(f"Fig. {number}: finite elements within {difference:.0e}")
        if not options.fig:
            slowest = compute_relaxation_times(problem, (2, 5) if quick else (2, 4, 5, 8, 16))
            slowest.to_dataframe("over_slower").to_csv(out / "relaxation.csv")
            many = (64, 128) if quick else (256, 512, 1024)
            quantities = claims.measure_running_in(five, slowest)
            quantities |= claims.measure_wear_ratios(curves[6], many)
            quantities |= claims.measure_width_ratios(curves[7], quantities["wear"])
            table = claims.judge_claims(quantities)
            table.to_csv(out / "claims.csv", index=False)
            conclusions += [*claims.conclude(table), claims.definitions()]
    return conclusions
