"""The examples of the README run unchanged and print the results that they promise."""

import ast
import json
import re
from itertools import pairwise
from pathlib import Path
from runpy import run_path

import pytest

EXAMPLES = Path(__file__).parents[2] / "studies" / "examples"


@pytest.fixture
def show(tmp_path, monkeypatch, capsys):
    """``show(name)`` returns the output of an example that runs in its own directory."""

    def show_example(name):
        file = EXAMPLES / f"{name}.py"
        assert len(file.read_text("utf-8").splitlines()) <= 30
        monkeypatch.chdir(tmp_path)
        run_path(str(file), run_name="__main__")
        return capsys.readouterr().out

    return show_example


@pytest.mark.slow
def test_a_convergence_study(show, tmp_path):
    rows = re.findall(r"rtol (\S+): indentation (\S+), steady slope (\S+)", show("convergence"))
    assert len(rows) == 4
    for rtol, *errors in rows:
        assert max(map(float, errors)) < float(rtol)
    assert (tmp_path / "convergence.png").exists()


@pytest.mark.slow
def test_thin_layers(show, tmp_path):
    """Relaxation times differ less if the layer is thinner."""
    ratios = [float(value) for value in re.findall(r"over fifth (\S+)", show("thin_layers"))]
    assert ratios == sorted(ratios)
    assert ratios[0] < 1.02
    # without a layer their ratio is about 1 to 1/4
    assert ratios[-1] == pytest.approx(4.1, abs=0.2)
    assert (tmp_path / "thin_layers.png").exists()


@pytest.mark.slow
def test_fem_against_mdr(show, tmp_path):
    assert show("fem_against_mdr").startswith("The methods agree")
    assert (tmp_path / "fem_against_mdr.png").exists()


def test_a_seal(show, tmp_path):
    first, verdict = show("seal").splitlines()
    assert re.fullmatch(r"90 % of the running-in take \d+\.\d h\.", first)
    assert verdict == "agree"
    assert (tmp_path / "seal.png").exists()


@pytest.mark.slow
def test_results_of_a_model(show):
    """Poisson's ratio is named: it is left out of the plane strain modulus."""
    *rows, words = show("my_results").splitlines()
    assert float(rows[1].split()[-1]) == pytest.approx(0.91 - 1, abs=1e-3)
    assert "Poisson's ratio" in words


def test_own_mesh(show):
    errors = [float(value) for value in re.findall(r"E\*\) (\S+)", show("own_mesh"))]
    # first order in the size at the rim, which is halved each time
    ratios = [coarse / fine for coarse, fine in pairwise(errors)]
    assert 1.7 < min(ratios) <= max(ratios) < 2.3


@pytest.mark.slow
def test_wear_scars(show):
    """The coefficients of steel are those of the published volumes, to 2 %.

    Under alumina, the elastic indentation takes 4 % of the cap (`test_wear_scars.by_geometry`).
    """
    rows = re.findall(r"k = (\S+) .* by the scar,\n    V / \(F s\) = (\S+)", show("wear_scars"))
    ratios = [float(found) / float(by_volume) for found, by_volume in rows]
    assert ratios == pytest.approx([1.0, 1.0, 0.96], abs=0.02)


@pytest.mark.gmsh
@pytest.mark.parametrize("name", ["first_steps", pytest.param("orders", marks=pytest.mark.slow)])
def test_the_notebook_has_the_outputs_of_its_cells(name, capsys):
    """The printed text and the last value of each cell equal the outputs stored in the notebook."""
    notebook = json.loads((EXAMPLES / f"{name}.ipynb").read_text("utf-8"))
    cells, names = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"], {}
    for cell in cells:
        code = ast.parse("".join(cell["source"]))
        last = code.body.pop() if isinstance(code.body[-1], ast.Expr) else None
        exec(compile(code, "cell", "exec"), names)
        value = last and eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        shown = capsys.readouterr().out + ("" if value is None else repr(value))
        parts = (out.get("text") or out["data"]["text/plain"] for out in cell["outputs"])
        assert shown == "".join(line for part in parts for line in part)
    assert sum(bool(cell["outputs"]) for cell in cells) == len(cells)
