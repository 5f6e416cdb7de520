"""Compute a sweep by two workers of a Dask scheduler; needs the extra `sweep`."""

from distributed import Client

from ringwear import sweep

if __name__ == "__main__":
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=":0") as client:
        executor = client.get_executor(pure=False)
        axes = {"punch.rings": [2, 4, 8]}
        found = sweep("five_rings", axes, "rings", executor, keep="indentation")
        print(found.indentation.sel(solver="mdr").to_series())
