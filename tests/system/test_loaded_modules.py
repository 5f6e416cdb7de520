"""Commands and runs load only the libraries that they need."""

import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest


def load_step_by_step(out):
    """Do light jobs first; none of them loads a library that it does not need."""
    import ringwear
    from ringwear import main

    def assert_absent(modules):
        assert not {name.split(".")[0] for name in sys.modules} & set(modules.split())

    for command in ([], ["run"], ["study"]):
        with pytest.raises(SystemExit, match="0"):
            main([*command, "--help"])
    assert_absent("numpy pydantic")
    scene = ringwear.Scene.load("five_rings").changed(accuracy__rtol=1e-2)
    assert main(["scenes"]) == 0
    heavy = "gmsh skfem matplotlib meshio kvxopt pint dask pandas xarray"
    assert_absent(f"{heavy} scipy netCDF4 threadpoolctl")
    assert main(["run", "five_rings", "--memory", "0.1", "--out", out]) == 2
    assert_absent(f"{heavy} netCDF4 threadpoolctl")
    ringwear.run(scene.changed(methods=["mdr", "direct"]))
    assert_absent(heavy)
    ringwear.run(scene.changed(methods=["fem"], accuracy__fem__mesher="bisection"))
    assert_absent("gmsh matplotlib meshio pandas xarray")
    # it takes a tenth of a second to load
    assert "scipy.optimize" not in sys.modules


def run_direct_alone(out):
    """Run the steady state by direct integration, without and with figures."""
    from ringwear import main

    def loaded():
        return {name.split(".")[0] for name in sys.modules}

    command = ["run", "five_rings", "--methods", "direct", "--out"]
    assert main([*command, f"{out}_numbers", "--no-figures"]) == 0
    unneeded = {"gmsh", "skfem", "meshio", "kvxopt", "pandas", "xarray"}
    assert not loaded() & {"matplotlib", "pint", *unneeded}
    assert main([*command, f"{out}_figures"]) == 0
    assert not loaded() & unneeded
    assert "matplotlib.pyplot" not in sys.modules


@pytest.mark.slow
@pytest.mark.parametrize("job", [load_step_by_step, run_direct_alone])
def test_a_job_loads_only_the_libraries_that_it_needs(tmp_path, job):
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        fresh.submit(job, str(tmp_path / "out")).result()
