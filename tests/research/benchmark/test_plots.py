from __future__ import annotations

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from meshmark.research.benchmark.figures.aggregate import Robustness, robustness
from meshmark.research.benchmark.page.calibration import calibration_plot, share_at_or_below
from meshmark.research.benchmark.page.curves import Series, curve_plot, dot_plot
from meshmark.research.benchmark.page.drawing import COLOURS, legend
from meshmark.research.benchmark.page.mark_plots import distortion_plot, time_plot
from meshmark.research.benchmark.page.plots import plots
from meshmark.research.benchmark.page.report_parts import Entry
from tests.counting import some
from tests.research.benchmark.planted import planted_rows

ROOT = Path(__file__).parents[3]
ROWS = planted_rows(models=16)


@cache
def figures() -> list[Robustness]:
    return [f for f in robustness(ROWS) if (f.split, f.size_class, f.budget) == ("test", "all", "standard")]


@cache
def series() -> list[Series]:
    return [Series(Entry(words="ncdg_lv, standard", colour=0), tuple(figures()))]


def test_attacks_of_several_strengths_have_curves_and_the_others_dots():
    curves = curve_plot("ber", "t", "c", series(), "ber")
    assert [panel.name for panel in curves.panels] == [
        "ber-noise", "ber-smoothing", "ber-quantisation", "ber-crop", "ber-simplification",
    ]  # fmt: skip
    (dots,) = dot_plot("dots", "t", "c", series(), "recovered").panels
    words = "".join(etree.fromstring(dots.svg).itertext())
    assert all(name in words for name in ("untouched", "similarity", "through OBJ", "crop 10 % +"))
    assert "quantisation" not in words


def line_of(svg: str, colour: str) -> list[tuple[float, float]]:
    """Return the corners of the line in a colour, in the picture's units."""
    stroke = rf'd="([^"]*)"[^>]*style="[^"]*fill: none; stroke: var\(--\w+, {colour}\); stroke-width: 1.5'
    (path,) = re.findall(stroke, svg)
    return [(float(x), float(y)) for x, y in re.findall(r"[ML] ([\d.]+) ([\d.]+)", path)]


def test_a_curve_shows_the_figures_and_distances_on_its_axis_are_true():
    plot = curve_plot("exact", "t", "c", series(), "recovered")
    (panel,) = [panel for panel in plot.panels if panel.name == "exact-simplification"]
    x, y = np.array(line_of(panel.svg, COLOURS[0])).T
    rates = {f.attack: f.recovered.value for f in figures()}
    shown = [rates["none"], rates["simplification:0.5"], rates["simplification:0.9"]]
    assert len(set(shown)) > 1
    slope, at_zero = np.polyfit(shown, y, 1)
    assert slope < 0, "up is more"
    assert np.allclose(slope * np.array(shown) + at_zero, y, atol=0.01)
    assert (x[2] - x[0]) / (x[1] - x[0]) == pytest.approx(0.9 / 0.5, rel=1e-3), (
        "0, 50 and 90 % at true distances"
    )


def test_harm_grows_to_the_right_where_fewer_bits_are_worse():
    plot = curve_plot("exact", "t", "c", series(), "recovered")
    (panel,) = [panel for panel in plot.panels if panel.name == "exact-quantisation"]
    x = [x for x, _ in line_of(panel.svg, COLOURS[0])]
    assert len(x) == 3, "no point for untouched models: 0 bits are not the mild end"
    labels = re.findall(r">(7|9|12)</text>", panel.svg)
    assert set(labels) == {"7", "9", "12"}
    assert "12 bits: " in panel.alt


def test_the_slope_of_time_is_the_planted_one():
    embed, _ = time_plot(ROWS).panels
    assert "slope 1.2" in "".join(etree.fromstring(embed.svg).itertext())


def test_calibration_compares_with_the_uniform_law():
    assert share_at_or_below(np.array([-0.5, -1.0, -3.0, 0.0]), -1.0) == 0.5
    many = planted_rows(models=20, repeats=40)
    plot = calibration_plot(many)
    bounds = np.array([r.log10_false_positive for r in many if r.case.trial == "unmarked"])
    assert share_at_or_below(bounds, -1.0) == pytest.approx(0.1, abs=0.03), "planted: true p"
    assert f"n = {len(bounds)}" in plot.legend[0].words
    assert calibration_plot([row for row in ROWS if row.case.trial == "marked"]) is None


def test_the_distortion_plot_tells_the_medians():
    panels = {panel.name: panel.alt for panel in distortion_plot(ROWS).panels}
    assert set(panels) == {f"distortion-{b}-{m}" for b in ("standard", "subtle") for m in ("rms", "msdm2")}
    values = {
        row.case.model: 100 * row.rms_over_diagonal
        for row in ROWS
        if row.case.budget == "standard" and row.rms_over_diagonal and row.size_class == "500-2,500"
        and row.case.attack == "crop:0.03"
    }  # fmt: skip
    assert "500-2,500 points: median" in panels["distortion-standard-rms"]
    assert values


def test_panels_have_names_of_their_own_and_colours_that_a_page_can_set():
    drawn = [
        panel for group in plots(planted_rows(models=8)).values() for plot in group for panel in plot.panels
    ]
    assert len({panel.name for panel in drawn}) == len(drawn)
    for panel in some(drawn):
        etree.fromstring(panel.svg)
        bare = re.sub(r"var\(--\w+, #[0-9a-f]{6}\)", "", panel.svg)
        assert not re.search(r"#[0-9a-f]{6}\b(?<!#000000)(?<!#ffffff)", bare)
        assert "<metadata" not in panel.svg


def test_nothing_of_matplotlibs_global_state_is_used():
    import matplotlib

    before = dict(matplotlib.rcParams)
    legend("l", (Entry(words="one", colour=0), Entry(words="two", colour=1, dash=1)))
    plots(planted_rows(models=3, budgets=("standard",)))
    assert dict(matplotlib.rcParams) == before


def test_pyplot_is_not_imported():
    program = (
        "import sys; from meshmark.research.benchmark.page.plots import plots; "
        "from tests.research.benchmark.planted import planted_rows;"
        "plots(planted_rows(models=2, budgets=('standard',))); print('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert done.stdout.strip() == "False"
