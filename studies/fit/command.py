"""The command `ringwear fit`."""

from argparse import Namespace
from pathlib import Path

from ..crosscheck import Scene, output_folder
from ..crosscheck.result.output.folder import Folder
from ..report.terminal import print_lines
from .fit import fit
from .result import FILES


def conduct(options: Namespace, out: Path) -> tuple[Folder, list[str], bool]:
    """Run a fit, print its conclusions, and write its files to a folder.

    Returns
    -------
    folder : the output folder
    failures : messages on files that could not be made
    fits : whether the model fits the data
    """
    scene = Scene.load(options.scene)
    with output_folder(out, "fit", FILES) as folder:
        result = fit(
            scene,
            options.data,
            options.parameters,
            options.noise,
            options.density,
            options.design,
            options.columns,
            options.units,
        )
        print_lines(["", *repr(result).split("\n")])
        failures = result.write(folder.hidden)
    return folder, failures, result.fits
