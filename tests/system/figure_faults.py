"""Find faults of a figure from the extents of its texts, without looking at it."""

import re
from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg


def shown_labels(axis):
    """Return the visible tick labels of an axis."""
    if not axis.get_visible():
        return []
    place = axis.get_transform().transform
    low, high = sorted(place(axis.get_view_interval()))
    beyond = 1e-9 * (high - low)
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    shown = [tick for tick in ticks if low - beyond <= place(tick.get_loc()) <= high + beyond]
    labels = [label for tick in shown for label in (tick.label1, tick.label2)]
    return [label for label in labels if label.get_visible() and label.get_text()]


def is_labelled(axis):
    """Return whether an axis is meant to have labels at its ticks."""
    settings = axis.get_tick_params()
    sides = ("labelleft", "labelright", "labelbottom", "labeltop")
    shown = axis.get_visible() and any(settings.get(side) for side in sides)
    return shown and len(axis.get_major_locator()()) > 0


def digits(label):
    """Return the significant digits of a label, of the first factor if there is a power of ten."""
    number = re.match(r"[−-]?([0-9.]*)", label)[1]
    written = number.replace(".", "").lstrip("0")
    return len(written if "." in number else written.rstrip("0"))


def _texts(figure):
    """Return the kind and the text of all visible texts."""
    texts = []
    for axes in filter(lambda axes: axes.get_visible(), figure.axes):
        for axis in (axes.xaxis, axes.yaxis):
            texts += [("tick", label) for label in shown_labels(axis)]
            texts += [("label", axis.label)] * axis.get_visible()
        texts += [("title", text) for text in (axes.title, axes._left_title, axes._right_title)]
        texts += [("text", text) for text in axes.texts]
    for legend in figure.legends:
        texts += [("legend", text) for text in [*legend.get_texts(), legend.get_title()]]
    if figure._suptitle:
        texts.append(("title", figure._suptitle))
    return [(what, text) for what, text in texts if text.get_visible() and text.get_text()]


def _overlap(first, second):
    """Return whether two boxes overlap by more than the rounding of a pixel."""
    across = min(first.x1, second.x1) - max(first.x0, second.x0)
    down = min(first.y1, second.y1) - max(first.y0, second.y0)
    return across > 0.5 and down > 1.5


def faults(figure):
    """Return a list of the faults of a figure, one line each."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer, messages = canvas.get_renderer(), []
    for axes in filter(lambda axes: axes.axison, figure.axes):
        for axis in (axes.xaxis, axes.yaxis):
            name, labels = axis.label.get_text(), shown_labels(axis)
            if offset := axis.get_offset_text().get_text():
                messages.append(f"{offset!r} beside the axis {name!r}")
            if len(labels) < 2 and is_labelled(axis):
                messages.append(f"{len(labels)} tick labels at {name!r}")
            messages += [
                f"{label.get_text()!r} at {name!r}"
                for label in labels
                if digits(label.get_text()) > 3
            ]
        low, high = sorted(axes.get_ylim())
        if axes.get_yscale() == "linear" and high - low < 0.00999 * max(abs(low), abs(high)):
            messages.append(f"{axes.get_ylabel()!r} spans {low} to {high} only")
    whole = figure.bbox
    boxes = [
        (what, text.get_text(), text.get_window_extent(renderer)) for what, text in _texts(figure)
    ]
    for what, text, box in boxes:
        within = box.x0 > whole.x0 - 1 and box.x1 < whole.x1 + 1
        if not (within and box.y0 > whole.y0 - 1 and box.y1 < whole.y1 + 1):
            messages.append(f"{what} {text!r} leaves the figure")
        panels = [axes.get_window_extent(renderer) for axes in figure.axes if axes.get_visible()]
        if what in ("tick", "label", "legend") and any(_overlap(box, panel) for panel in panels):
            messages.append(f"{what} {text!r} is over a panel")
    messages += [
        f"{first[0]} {first[1]!r} is over {second[0]} {second[1]!r}"
        for first, second in combinations(boxes, 2)
        if _overlap(first[2], second[2])
    ]
    return messages
