"""Names of hands in their plane meet neither each other, nor the dashed line, nor the edge of the axes."""

from __future__ import annotations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.figures.stability import stability_figure


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring"])
def test_names_of_hands_stand_free(name: str) -> None:
    """At fu2019 device-operator lay on the line of the root at 0; behind a delay two names left the axes or met the number."""
    found = hs.stability(name, "postural-arm")
    figure = stability_figure(found)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    [ax] = figure.axes
    boxes = [x.get_window_extent(canvas.get_renderer()) for x in ax.texts if isinstance(x, Annotation)]
    assert len(boxes) >= 6
    at_0 = float(ax.transData.transform((-100.0, 0.0))[0])  # both environments have 100 N/m
    edge = ax.get_window_extent()
    for i, box in enumerate(boxes):
        assert edge.x0 < box.x0
        assert box.x1 < edge.x1
        assert edge.y0 <= box.y0 + 0.25 * box.height
        if box.height < 12 * figure.dpi / 72 and box.width > 3 * box.height:  # a name, no number
            assert not box.x0 < at_0 < box.x1
        assert not any(
            box.overlaps(other) and box.intersection(box, other).height > 0.3 * box.height for other in boxes[:i]
        )
