"""Small pictures as SVG that reads on light and dark ground: matplotlib without its global state.

Colours become CSS variables with the light colour as fallback: a page sets them for its own ground, and a file
shown alone has white paper. The same data give the same bytes.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from meshmark.research.benchmark.page.report_parts import Entry, Panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "DASHES",
    "INK",
    "MARKERS",
    "PAPER",
    "SOFT",
    "draw",
    "has_matplotlib",
    "legend",
]

# Okabe and Ito's palette, told apart with any colour vision; its yellow and black made a brown and a grey.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5c3e", "#6b7280")
MARKERS = "os^DvPXh"
DASHES = ("solid", (0, (4, 2)), (0, (1, 1.5)))
INK, SOFT, GRID, PAPER = "#1b1d21", "#5c626c", "#d8dbe0", "#fffffe"
_VARIABLES = {
    INK: "ink",
    SOFT: "soft",
    GRID: "grid",
    PAPER: "paper",
    **{colour: f"c{i}" for i, colour in enumerate(COLOURS)},
}
_STYLE: dict[Any, Any] = {
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.0,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": SOFT,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 0.0,
    "figure.facecolor": PAPER,
    "legend.frameon": False,
    "svg.fonttype": "none",
}
# Inches. Pages show a panel about as wide as it is, so that its text keeps a readable size.
_WIDTH, _LETTER, _RIGHT, _BELOW, _ABOVE = 3.7, 0.062, 0.2, 0.44, 0.27


def has_matplotlib() -> bool:
    """Return whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def draw(
    name: str,
    alt: str,
    paint: Callable[[Axes], None],
    *,
    height: float = 2.3,
    words: Sequence[str] = ("00 %",),
) -> Panel:
    """Return a panel of one pair of axes; `paint` draws into them.

    height: inches. words: those that stand left of the axes, which get the room that the longest needs.
    """
    letters = max((len(line) for text in words for line in text.split("\n")), default=0)
    left = 0.24 + _LETTER * letters

    def fill(figure: Figure) -> None:
        room = (
            left / _WIDTH,
            _BELOW / height,
            1.0 - (left + _RIGHT) / _WIDTH,
            1.0 - (_BELOW + _ABOVE) / height,
        )
        paint(figure.add_axes(room))

    return Panel(name=name, alt=alt, svg=_svg(name, fill, height))


def legend(name: str, entries: tuple[Entry, ...]) -> str:
    """Return the SVG of a legend, for places that cannot make one themselves."""

    def fill(figure: Figure) -> None:
        from matplotlib.lines import Line2D

        lines = [
            Line2D([], [], color=COLOURS[e.colour], marker=MARKERS[e.colour], ms=4, ls=DASHES[e.dash])
            for e in entries
        ]
        figure.legend(lines, [entry.words for entry in entries], loc="center left", fontsize=8)

    return _svg(name, fill, 0.1 + 0.19 * len(entries))


def _svg(name: str, fill: Callable[[Figure], None], height: float) -> str:
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    target = io.StringIO()
    with matplotlib.rc_context({**_STYLE, "svg.hashsalt": name}):
        figure = Figure(figsize=(_WIDTH, height))
        canvas = FigureCanvasSVG(figure)
        fill(figure)
        # `savefig` would lay everything out twice; positions are fixed here.
        canvas.print_svg(target, metadata={"Date": None})  # type: ignore[no-untyped-call]
    return _themed(target.getvalue(), name)


def _themed(svg: str, name: str) -> str:
    """Return the SVG alone, its identifiers made unique by the name, its colours and font left to the page."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\b(id="|href="#|url\(#)', lambda match: f"{match[1]}{name}-", svg)
    svg = re.sub(r"'DejaVu Sans'[^;\"]*", "system-ui, 'DejaVu Sans', sans-serif", svg)
    svg = re.sub(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', _OPENING, svg, count=1)
    return re.sub(
        "|".join(_VARIABLES), lambda match: f"var(--{_VARIABLES[match[0]]}, {match[0]})", svg
    ).strip()


_OPENING = (
    r'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="\1" '
    r'role="img">'
)
