"""Show how errors of finite elements follow `rtol`: slope by closed form, d(t) by a finer run."""

import pandas as pd

from ringwear import Scene, run

scene = Scene.load("five_rings").changed(wear__times=[0.0, 0.1, 1.0])
exact = run(scene, methods=["mdr", "direct"], rtol=1e-8).dataset
table = pd.DataFrame(index=[1e-1, 1e-2, 1e-3, 1e-4], columns=["indentation", "steady slope"])
for rtol in table.index:
    fem = run(scene, methods=["fem"], rtol=rtol).dataset.sel(solver="fem")
    indentation = abs(fem.indentation / exact.indentation.sel(solver="mdr") - 1).max()
    slope = abs(fem.steady_rms_slope / exact.steady_rms_slope.sel(solver="direct") - 1)
    table.loc[rtol] = float(indentation), float(slope)
    print(f"rtol {rtol:.0e}: indentation {indentation:.1e}, steady slope {slope:.1e}")

axes = table.plot(loglog=True, style="o-", xlabel="rtol", ylabel="relative error")
axes.figure.savefig("convergence.png")
