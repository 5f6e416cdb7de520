"""Orders of exact sequences, Richardson's limit, and tables of refinements that were published."""

import numpy as np
import pandas as pd
import pytest

from ringwear import SceneError, orders
from ringwear.studies.study.declared import observed_orders
from ringwear.studies.study.extrapolation import (
    order_of_changes,
    order_of_errors,
    order_of_three,
)
from ringwear.studies.study.way import OTHERS, Part, Theory, Way

SIZES = np.array([0.5, 0.3, 0.2, 0.1])


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 7.5])
def test_orders_of_an_exact_sequence(order):
    errors, values = 0.3 * SIZES**order, 1 - 0.3 * SIZES**order
    assert order_of_errors(SIZES, errors).order == pytest.approx(order)
    changes = np.abs(np.diff(values))
    fitted = order_of_changes(SIZES, changes)
    assert fitted.order == pytest.approx(order, abs=1e-6)
    assert fitted.low <= fitted.order <= fitted.high
    assert order_of_three(SIZES[-3:], changes[-2:]) == pytest.approx(order)


def test_the_interval_is_that_of_students_distribution():
    from scipy.stats import linregress, t

    errors = SIZES**2 * np.array([1.1, 0.9, 1.05, 0.95])
    line = linregress(np.log(SIZES), np.log(errors))
    half = t.ppf(0.975, 2) * line.stderr
    expected = [line.slope, line.slope - half, line.slope + half]
    assert list(order_of_errors(SIZES, errors)) == pytest.approx(expected)


def levels_of(errors, theory, reference=0.0):
    """Return the observed order of a sequence as a study fits it."""
    way = Way("h", "fem", range(4), None, "size", theory={OTHERS: theory})
    table = pd.DataFrame({"size": SIZES, "error": errors, "unknowns": 1 / SIZES})
    constant = {"case": "scene", "way": "h", "quantity": "indentation", "when": "start"}
    table = table.assign(**constant, reference=reference, index=np.nan, limit=np.nan)
    (row,) = observed_orders(table, {"scene": [way]}).to_dict("records")
    return row


def test_levels_below_the_floor_are_left_out_of_orders():
    errors = np.maximum(SIZES**2, 0.045)
    for floor, reference in ((0.05, 0.0), (0.0, 0.05)):
        row = levels_of(errors, Theory(2.0, floor=floor), reference)
        assert row["order"] == pytest.approx(2)


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        (SIZES**2, ""),
        (SIZES**2.2, "differs from theory."),
        (SIZES**2 * (1 - SIZES), "differs from theory."),
        (np.array([1.0, 0.0, 0.0, 0.0]), "too few levels above the error of the reference."),
        # the fitted order is right by chance, but that of the last levels is not
        (np.array([0.5**2, 0.3**2, 0.2**2, 0.9 * 0.1**2]), "differs from theory."),
    ],
)
def test_verdicts_on_orders(errors, verdict):
    assert levels_of(errors, Theory(2.0))["remark"] == verdict
    assert "differs" not in levels_of(errors, Theory())["remark"]


# Slater, Examining spatial (grid) convergence, NPARC Alliance verification and validation (2021):
# pressure recovery of an inlet on grids with the spacings 1, 2 and 4
NPARC = pd.DataFrame({"h": [1.0, 2.0, 4.0], "recovery": [0.97050, 0.96854, 0.96178]})
# Celik et al., J. Fluids Eng. 130 (2008), doi 10.1115/1.2960953, table 1: a reattachment length,
# and a velocity, on grids with these numbers of cells in the plane
LENGTH = pd.DataFrame({"cells": [18000, 8000, 4500], "length": [6.063, 5.972, 5.863]})
VELOCITY = pd.DataFrame({"cells": [18000, 4500, 980], "velocity": [10.7880, 10.7250, 10.6050]})


@pytest.mark.parametrize(
    ("table", "order", "limit", "index"),
    [
        (NPARC, (1.786170, 1e-6), (0.97130, 5e-6), (0.00103083, 1e-8)),
        (LENGTH, (1.53, 5e-3), (6.1685, 5e-5), (0.022, 5e-4)),
        (VELOCITY, (0.75, 5e-3), (10.8801, 5e-5), (0.011, 5e-4)),
    ],
)
def test_published_refinements_have_the_printed_orders(table, order, limit, index):
    if "cells" in table:
        table = table.assign(h=table.cells**-0.5).drop(columns="cells")
    # the order of rows does not matter
    for rows in (table, table[::-1]):
        (row,) = orders(rows, by="h").to_dict("records")
        for name, (printed, digits) in (("order", order), ("limit", limit), ("index", index)):
            assert row[name] == pytest.approx(printed, abs=digits), name
        assert np.isnan(row["asymptotic"])


def test_errors_and_values_of_a_table():
    table = pd.DataFrame({"h": SIZES, "depth": 2 + SIZES**2, "L2 error": SIZES**3})
    table["swinging"] = [1.0, -1.0, 1.0, -1.0]
    found = orders(table, by="h", right={"depth": 2.0}, tolerance=0.004).set_index("quantity")
    assert found.order[["depth", "L2 error"]].tolist() == pytest.approx([2, 3])
    assert np.isnan(found.order["swinging"])
    assert found.loc["depth", ["target", "ratio", "within"]].tolist() == [2.0, 1.005, "no"]
    assert found.within["L2 error"] == "yes"
    assert found.asymptotic["depth"] == 1


def test_orders_on_the_command_line(command, tmp_path):
    NPARC.to_csv("grids.csv", index=False)
    call = "orders grids.csv --by h --right recovery=0.9713 --tolerance {}"
    assert "1.786" in command(f"{call.format(1e-2)} --out out --latex").out
    row = pd.read_csv(tmp_path / "out" / "orders.csv").iloc[0]
    assert (row.target, row.within) == (0.9713, "yes")
    assert "recovery" in (tmp_path / "out" / "orders.tex").read_text()
    assert "| no " in command(call.format(1e-6), 3).out
    assert "give NAME=VALUE" in command("orders grids.csv --by h --right x", 2).err


@pytest.mark.parametrize(
    ("table", "by", "message"),
    [
        (NPARC, "H", "did you mean 'h'"),
        (NPARC[:2], "h", "three levels or more"),
        (NPARC.assign(h=[1.0, 1.0, 2.0]), "h", "another positive size"),
        (NPARC[["h"]], "h", "no numbers besides"),
        ([1, 2, 3], "h", "is no table"),
    ],
)
def test_tables_without_an_order_are_refused(table, by, message):
    with pytest.raises(SceneError, match=message):
        orders(table, by=by)


def test_names_of_quantities_in_sentences():
    assert str(Part("rms_slope", "later")) == "RMS slope, later"
    assert str(Part("steady_profile")) == "steady profile"
