"""Write HTML pages as single files that need no network and can be printed on A4."""

import base64
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..crosscheck import Scene, package_versions
from ..tables.writing import json_text


class Shown(NamedTuple):
    """A figure on a page: the image, in base 64, and its caption."""

    image: str
    caption: str


def write_page(
    path: Path, template: str, scene: Scene, captions: dict[str, str], **context: Any
) -> None:
    """Write a page from a template, with the captioned figures that are in the same folder.

    The template gets them as `pictures`, by the names of their files.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_function"] = json_text
    pictures = {
        name: Shown(base64.b64encode(file.read_bytes()).decode(), caption)
        for name, caption in captions.items()
        if (file := path.parent / name).exists()
    }
    page = environment.get_template(template).render(
        pictures=pictures, scene=scene.to_toml(), versions=package_versions(), **context
    )
    path.write_text(page, "utf-8")
