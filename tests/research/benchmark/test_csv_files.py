from __future__ import annotations

import csv
import io

from hypothesis import given
from hypothesis import strategies as st

from meshmark.research.benchmark.figures.aggregate import robustness
from meshmark.research.benchmark.figures.csv_files import read_results, results_csv, summary_csv
from meshmark.research.benchmark.run.row import Case, Row
from tests.counting import some
from tests.research.benchmark.planted import planted_rows

TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\r\x00"), max_size=12)
MAYBE = st.none() | st.floats(allow_nan=False)
CASES = st.builds(Case, TEXT, TEXT, TEXT, TEXT, TEXT, TEXT, st.integers(0, 99), st.integers(0, 99))
ROWS = st.builds(
    Row, case=CASES, status=TEXT, note=TEXT, points=st.none() | st.integers(0, 10**9), ber=MAYBE, msdm2=MAYBE,
    present=st.none() | st.booleans(), recovered=st.none() | st.booleans(), peak_mb=MAYBE,
)  # fmt: skip


@given(st.lists(ROWS, max_size=5, unique_by=lambda row: row.case))
def test_rows_come_back_exactly(rows):
    assert read_results(results_csv(rows)) == sorted(rows, key=lambda row: row.case)


def test_the_order_of_rows_does_not_show():
    rows = planted_rows(models=3)
    assert results_csv(rows) == results_csv(rows[::-1])


def test_the_summary_has_a_line_for_each_group_with_its_interval():
    figures = robustness(planted_rows(models=6))
    lines = list(csv.DictReader(io.StringIO(summary_csv(figures))))
    assert len(lines) == len(figures)
    for line, figure in some(zip(lines, figures, strict=True)):
        assert (line["attack"], line["size_class"]) == (figure.attack, figure.size_class)
        assert float(line["recovered_low"]) == figure.recovered.low
        assert line["ber"] == ("" if figure.ber is None else repr(figure.ber.value))
