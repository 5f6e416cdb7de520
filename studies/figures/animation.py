"""The wearing punch as a moving picture: its face turned up, heights drawn far larger than they are."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ringwear.meshes.radial import Array, ring_of
from ringwear.studies.figures.history import smooth
from ringwear.studies.figures.scale import Scale
from ringwear.studies.figures.style import heading, new_figure, styled, titled
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import array
from ringwear.studies.problem.scene import Scene

FRAMES, MILLISECONDS = 30, 120
# radii and angles of the surface, and the part of the radius that the greatest difference of heights is drawn as
RADII, ANGLES, HEIGHT = 70, 49, 0.45
SLOW, FAST = np.array([0.38, 0.47, 0.57]), np.array([0.88, 0.82, 0.67])


@styled
def animate(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Write the running-in as an animated GIF, of a scene for which `cannot_be_animated` is empty."""
    found = smooth(scene.problem, solutions)
    assert found is not None
    times, profiles = array(found[1], "time"), array(found[1], "profile")
    shown = np.linspace(0, len(times) - 1, FRAMES).astype(int)
    labels = [Scale(scene).when(time * scene.problem.units.time) for time in times[shown]]
    frames = list(_frames(scene, profiles[shown], labels))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0)


def _frames(scene: Scene, profiles: Array, labels: list[str]) -> Iterator[Image.Image]:
    problem, rings = scene.problem, scene.problem.rings
    worn = profiles - profiles.min(axis=1, keepdims=True)
    radii, angles = np.linspace(0, 1, RADII), np.linspace(-0.4, 1.6, ANGLES) * np.pi
    r, angle = np.meshgrid(radii, angles)
    shade = np.log(rings.wear_coefficients) - np.log(rings.wear_coefficients.min())
    of_ring = (shade / (shade.max() or 1.0))[ring_of(rings.ring_edges, radii)]
    colours = np.broadcast_to((SLOW + of_ring[:, None] * (FAST - SLOW))[None], (ANGLES, RADII, 3))
    for row, label in zip(worn, labels, strict=True):
        figure = new_figure(5, 3.6)
        figure.set_layout_engine("none")
        figure.set_dpi(120)
        # three-dimensional axes, and a canvas that keeps its pixels
        axes: Any = figure.add_axes((0, -0.08, 1, 1.1), projection="3d")
        canvas: Any = figure.canvas
        height = -HEIGHT * np.interp(radii, problem.radii, row) / (worn.max() or 1.0)
        surface = np.broadcast_to(height, r.shape)
        axes.plot_surface(
            r * np.cos(angle), r * np.sin(angle), surface, facecolors=colours, rstride=1, cstride=1, shade=True
        )
        axes.set(xlim=(-0.8, 0.8), ylim=(-0.8, 0.8), zlim=(-0.6, 0.2), box_aspect=(1, 1, 0.5))
        axes.view_init(elev=38, azim=-60)
        axes.set_axis_off()
        heading(figure, titled(scene.title, label))
        canvas.draw()
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("P", palette=Image.Palette.ADAPTIVE)
