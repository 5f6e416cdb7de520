"""Wear of ringed flat punches by tamaas: explicit steps of Archard's law on 64 x 64 points.

If it is run in this folder with tamaas installed (`pip install "tamaas>=2.9,<3"`), it writes the
tables that `tests/programs.py` reads. Plane strain modulus, radius, force and speed are 1.
"""

import numpy as np
import pandas as pd
import tamaas as tm

POINTS, SIZE, STEPS = 64, 2.2, 240

SCENES = {
    "tamaas_two": ([0.5, 1.0], [1.0, 0.2], [0.0, 0.1, 0.3, 0.8, 1.6, 3.0]),
    "tamaas_three": ([0.3, 0.7, 1.0], [1.0, 0.3, 1.0], [0.0, 0.05, 0.2, 0.5, 1.0, 2.0]),
}

x = ((np.arange(POINTS) + 0.5) / POINTS - 0.5) * SIZE
radii = np.hypot(*np.meshgrid(x, x))
along = POINTS // 2, slice(POINTS // 2, POINTS)

for name, (edges, coefficients, times) in SCENES.items():
    wear = np.append(coefficients, 0.0)[np.searchsorted(edges, radii)]
    heights = np.where(radii > 1, 1e3, 0.0)
    profile, rows, time = 0 * radii, [], 0.0
    for end in times:
        count = max(1, round(STEPS * (end - time) / times[-1]))
        for step in range(count + 1):
            model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIZE, SIZE], radii.shape)
            model.E, model.nu = 1, 0
            tm.ModelFactory.registerNonPeriodic(model, "free")
            solver = tm.PolonskyKeerRey(model, -(heights + profile), 1e-10)
            solver.setIntegralOperator("free")
            solver.solve(1 / SIZE**2)
            pressure = model.traction.copy()
            if step < count:
                profile = profile + wear * pressure * (end - time) / count
        time = end
        model.operators["free"](model.traction, model.displacement)
        moved = model.displacement.copy()
        depth = (moved + profile)[along][0]
        columns = end, radii[along], pressure[along], moved[along], profile[along], depth
        rows.append(np.transpose(np.broadcast_arrays(*columns)))
    table = np.concatenate(rows)
    head = ["time", "radius", "pressure", "displacement", "profile", "indentation"]
    frame = pd.DataFrame(table[table[:, 1] < 1], columns=head)
    frame.to_csv(f"{name}.csv", index=False, float_format="%.6g")
