"""The command `ringwear fit`."""

from argparse import Namespace
from pathlib import Path

from ..output.folder import Folder, output_folder
from ..scene.scene import Scene
from .fit import fit
from .result import FILES


def conduct(options: Namespace, out: Path) -> tuple[Folder, list[str], bool]:
    """Fit, print what was found, and write it to a folder.

    Returns
    -------
    folder, failures, fits : the folder, what could not be made, and whether the model fits
    """
    scene = Scene.load(options.scene)
    with output_folder(out, "fit", FILES) as folder:
        found = fit(
            scene,
            {str(file): file for file in options.data},
            options.parameters,
            options.noise,
            options.density,
            options.design,
            options.columns,
            options.units,
        )
        print(f"\n{found}", flush=True)
        failures = found.write(folder.hidden)
    return folder, failures, found.fits
