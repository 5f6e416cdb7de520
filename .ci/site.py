"""Build the site with MkDocs: the pages of the repository, a gallery that is run, and the API.

python .ci/site.py DIR

MkDocs checks all links and pictures: a broken one stops the build.
"""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from base64 import b64decode
from functools import partial
from inspect import getdoc, ismodule
from pathlib import Path

import pdoc

import ringwear

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "studies" / "examples"
FOLDERS = ("mdr", "fem", "meshes", "studies", "tests")
PAGES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
LINK = re.compile(r"\]\((?!https?://|#|mailto:)([^)\s#]+)(#[^)\s]*)?\)")


def copy_pages(docs: Path) -> None:
    """Copy all pages of the repository, and the files that they link to, to the same places."""
    folders = [file for folder in FOLDERS for file in (ROOT / folder).rglob("*.md")]
    for file in (*(ROOT / page for page in PAGES), *sorted(folders)):
        place = docs / file.relative_to(ROOT)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(LINK.sub(partial(link_of, file.parent), read(file)), "utf-8")
        for target, _ in LINK.findall(read(file)):
            linked = (file.parent / target).resolve()
            if linked.is_file() and linked.suffix != ".md":
                copied = docs / shown_folder(str(linked.relative_to(ROOT)))
                copied.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(linked, copied)


def read(file: Path) -> str:
    """Return the text of a file."""
    return file.read_text("utf-8")


def link_of(folder: Path, match: re.Match[str]) -> str:
    """Return a link of a page in a folder; one to a folder leads to the page that describes it."""
    target, place = match.groups()
    if (folder / target).is_dir():
        target = f"{target.rstrip('/')}/README.md"
    return f"]({shown_folder(target)}{place or ''})"


def shown_folder(path: str) -> str:
    """Return the place of a file on the site, which has no folders whose names begin with a dot."""
    return path.replace(".github/", "pictures/")


def gallery(docs: Path) -> list[str | dict[str, str]]:
    """Write a page for each example, run in a folder of its own; return their navigation."""
    folder = docs / "gallery"
    folder.mkdir()
    pages = {file: page_of_script(file, folder) for file in sorted(EXAMPLES.glob("[!_]*.py"))}
    pages |= {file: page_of_notebook(file, folder) for file in sorted(EXAMPLES.glob("*.ipynb"))}
    titles = {}
    for file, text in pages.items():
        (folder / f"{file.stem}.md").write_text(text, "utf-8")
        titles[f"{file.stem}.md"] = text.partition("\n")[0].removeprefix("# ")
    parts = ["# Gallery", "Each page is a script or a notebook that is run."]
    for name, title in titles.items():
        parts.append(f"[{title}]({name})")
        parts += [
            f"[![{title}]({image.name})]({name})"
            for image in sorted(folder.glob(f"{Path(name).stem}_*.png"))[:1]
        ]
    (folder / "index.md").write_text("\n\n".join(parts) + "\n", "utf-8")
    pages_by_title = ({title.replace("`", ""): f"gallery/{name}"} for name, title in titles.items())
    return ["gallery/index.md", *pages_by_title]


def page_of_script(file: Path, folder: Path) -> str:
    """Return the page of an example: its question, code, output and figures.

    The code, which is run here, is also written as a notebook beside the page.
    """
    source = read(file)
    title, _, text = (ast.get_docstring(ast.parse(source)) or file.stem).partition("\n")
    with tempfile.TemporaryDirectory() as place:
        call = [sys.executable, str(file)]
        environment = os.environ | {"MPLBACKEND": "agg"}
        done = subprocess.run(
            call, cwd=place, env=environment, capture_output=True, text=True, check=True
        )
        figures = []
        for number, image in enumerate(sorted(Path(place).glob("*.png"))):
            name = f"{file.stem}_{number}.png"
            shutil.copy(image, folder / name)
            figures.append(f"![{image.stem.replace('_', ' ')}]({name})")
    code = source.partition('"""')[2].partition('"""')[2].strip()
    notebook = json.dumps(notebook_of(f"# {title}\n\n{text.strip()}", code), indent=1)
    (folder / f"{file.stem}.ipynb").write_text(notebook + "\n", "utf-8")
    link = f"[As a notebook]({file.stem}.ipynb)"
    parts = [f"# {title.rstrip('.')}", text.strip(), fenced(code, "python"), link]
    parts += [fenced(done.stdout)] if done.stdout.strip() else []
    return "\n\n".join(filter(None, [*parts, *figures])) + "\n"


def notebook_of(text: str, code: str) -> dict[str, object]:
    """Return a notebook with a text and a cell of code."""
    about: dict[str, object] = {"cell_type": "markdown", "id": "about", "source": text}
    cell = {"cell_type": "code", "id": "code", "source": code, "outputs": []}
    return {
        "cells": [about | {"metadata": {}}, cell | {"execution_count": None, "metadata": {}}],
        "metadata": {"kernelspec": {"display_name": "Python 3", "name": "python3"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def page_of_notebook(file: Path, folder: Path) -> str:
    """Return the page of a notebook, with the outputs that it holds (a test runs its cells)."""
    parts = []
    for number, cell in enumerate(json.loads(read(file))["cells"]):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(fenced(source, "python"))
        for out in cell["outputs"]:
            data = out.get("data", {})
            if picture := data.get("image/png"):
                name = f"{file.stem}_{number}.png"
                (folder / name).write_bytes(b64decode(picture))
                parts.append(f"![{source}]({name})")
            else:
                parts.append(fenced("".join(out.get("text") or data["text/plain"])))
    return "\n\n".join(parts) + "\n"


def fenced(text: str, language: str = "text") -> str:
    """Return a block of code or of output."""
    return f"```{language}\n{text.rstrip()}\n```"


def write_api(docs: Path) -> None:
    """Write the pages of the API, and refuse them if a public name is missing."""
    # names that load when they are used, so that pdoc shows what is there
    vars(ringwear).update({name: public(name) for name in ringwear.__all__})
    pdoc.render.configure(docformat="numpy")
    # it evaluates names of types where they are not imported, and shows them as they are written
    warnings.filterwarnings("ignore", "Error parsing type annotation", UserWarning)
    modules = [value.__name__ for value in map(public, ringwear.__all__) if ismodule(value)]
    pdoc.pdoc("ringwear", *modules, output_directory=docs / "api")
    text = read(docs / "api" / "ringwear.html")
    # modules have pages of their own
    wanted = [name for name in ringwear.__all__ if not ismodule(public(name))]
    wanted += ["Result.plot", "Study.save", "Comparison.table", "Scene.changed"]
    if missing := [name for name in wanted if f'id="{name}"' not in text]:
        raise SystemExit(f"the page of the API lacks {', '.join(missing)}")
    lines = ["# API", "", "The public names of ringwear, with their docstrings:", ""]
    for name in ringwear.__all__:
        place = f"ringwear.html#{name}"
        if ismodule(public(name)):
            place = f"{public(name).__name__.replace('.', '/')}.html"
        first, *_ = (getdoc(public(name)) or "").splitlines() or [""]
        lines.append(f"- [`{name}`](api/{place}) {first}".rstrip())
    (docs / "api.md").write_text("\n".join(lines) + "\n", "utf-8")


def public(name: str) -> object:
    """Return what a public name stands for."""
    return getattr(ringwear, name)


def build(out: Path) -> None:
    """Write the site into a folder."""
    with tempfile.TemporaryDirectory() as place:
        docs = Path(place) / "docs"
        copy_pages(docs)
        write_api(docs)
        shutil.copy(ROOT / ".ci" / "style.css", docs)
        # MkDocs reads JSON as YAML
        config = Path(place) / "mkdocs.yml"
        settings = read(ROOT / ".ci" / config.name)
        config.write_text(settings.replace("GALLERY", json.dumps(gallery(docs))), "utf-8")
        options = ["--strict", "-f", config, "--site-dir", out.resolve()]
        subprocess.run([sys.executable, "-m", "mkdocs", "build", *options], check=True)


if __name__ == "__main__":
    build(Path(sys.argv[1]))
