"""Build the site: pages of the API from docstrings, and the examples with what they print and draw.

python .ci/site.py DIR
"""

import ast
import json
import os
import subprocess
import sys
import tempfile
from base64 import b64encode
from html import escape
from inspect import ismodule
from pathlib import Path

import pdoc
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

import ringwear

EXAMPLES = Path(__file__).parents[1] / "studies" / "examples"
STYLE = """body { max-width: 60em; margin: 2em auto; padding: 0 1em; font-family: sans-serif }
pre { overflow-x: auto; padding: .5em; background: #f6f6f6 } img { max-width: 100% }"""


def load_late_names() -> None:
    """Give the package its public names that load when they are used: pdoc shows what is there."""
    vars(ringwear).update({name: public(name) for name in ringwear.__all__})


def public(name: str) -> object:
    """Return what a public name stands for."""
    return getattr(ringwear, name)


def as_page(title: str, parts: list[str]) -> str:
    """Return a page of HTML."""
    style = f"{STYLE}\n{HtmlFormatter().get_style_defs()}"
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        f"<title>{escape(title)}</title><style>{style}</style></head><body>"
        f"<h1>{escape(title)}</h1>{''.join(parts)}</body></html>"
    )


def of_code(source: str) -> str:
    """Return highlighted code."""
    return highlight(source, PythonLexer(), HtmlFormatter())


def of_text(text: str) -> str:
    """Return what was printed."""
    return f"<pre>{escape(text)}</pre>" if text.strip() else ""


def page_of_script(file: Path) -> str:
    """Return the page of an example, run in a folder of its own: code, output and figures."""
    source = file.read_text("utf-8")
    title = (ast.get_docstring(ast.parse(source)) or file.stem).splitlines()[0]
    with tempfile.TemporaryDirectory() as folder:
        call = [sys.executable, str(file)]
        environment = os.environ | {"MPLBACKEND": "agg"}
        done = subprocess.run(
            call, cwd=folder, env=environment, capture_output=True, text=True, check=True
        )
        figures = [b64encode(of.read_bytes()).decode() for of in sorted(Path(folder).glob("*.png"))]
    images = [f'<img alt="figure" src="data:image/png;base64,{image}">' for image in figures]
    return as_page(title, [of_code(source), of_text(done.stdout), *images])


def page_of_notebook(file: Path) -> str:
    """Return the page of a notebook, with the outputs that it holds (a test runs its cells)."""
    parts = []
    for cell in json.loads(file.read_text("utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts += [f"<p>{escape(source.lstrip('# '))}</p>"]
            continue
        outputs = (out.get("text") or out["data"]["text/plain"] for out in cell["outputs"])
        parts += [of_code(source), *(of_text("".join(lines)) for lines in outputs)]
    return as_page(file.stem.replace("_", " ").capitalize(), parts)


def build(out: Path) -> None:
    """Write the site into a folder."""
    load_late_names()
    pdoc.render.configure(docformat="numpy")
    modules = [value.__name__ for value in map(public, ringwear.__all__) if ismodule(value)]
    pdoc.pdoc("ringwear", *modules, output_directory=out / "api")
    pages = {file.stem: page_of_script(file) for file in sorted(EXAMPLES.glob("[!_]*.py"))}
    pages |= {file.stem: page_of_notebook(file) for file in sorted(EXAMPLES.glob("*.ipynb"))}
    (out / "examples").mkdir(parents=True, exist_ok=True)
    for name, page in pages.items():
        (out / "examples" / f"{name}.html").write_text(page, "utf-8")
    links = [f'<li><a href="examples/{name}.html">{name}</a></li>' for name in pages]
    api = '<p><a href="api/ringwear.html">The API</a></p>'
    index = as_page("ringwear", [api, f"<p>Examples</p><ul>{''.join(links)}</ul>"])
    (out / "index.html").write_text(index, "utf-8")
    check_all_names(out / "api" / "ringwear.html")


def check_all_names(page: Path) -> None:
    """Refuse a site whose page of the API lacks a public name, or the methods of a class."""
    text = page.read_text("utf-8")
    # modules have pages of their own
    wanted = [name for name in ringwear.__all__ if not ismodule(public(name))]
    wanted += ["Result.plot", "Study.save", "Comparison.table", "Scene.changed"]
    if missing := [name for name in wanted if f'id="{name}"' not in text]:
        raise SystemExit(f"the page of the API lacks {', '.join(missing)}")


if __name__ == "__main__":
    build(Path(sys.argv[1]))
