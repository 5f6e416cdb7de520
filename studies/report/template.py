"""A page: one file that opens from disk, without a network, and prints on A4."""

import base64
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..scene.scene import Scene
from ..versions import versions


def write_page(
    path: Path, template: str, scene: Scene, captions: dict[str, str], **about: Any
) -> None:
    """Write a page by a template, with those of the captioned figures that stand beside it."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    pictures = [
        (base64.b64encode(file.read_bytes()).decode(), caption)
        for name, caption in captions.items()
        if (file := path.parent / name).exists()
    ]
    page = environment.get_template(template).render(
        pictures=pictures, scene=scene.to_toml(), versions=versions(), **about
    )
    path.write_text(page, "utf-8")
