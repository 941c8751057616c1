"""The short table counts every case once."""

from __future__ import annotations

from meshmark.research.benchmark.figures.summary import Line, as_table, summary
from meshmark.research.benchmark.run.row import Case, Row


def row(attack, model, status="ok", **figures):
    return Row(case=Case("smoke", "toy", model, "standard", attack, "marked", 0), status=status, **figures)


ROWS = [
    row("noise:0.01", "a", ber=0.5, present=False, recovered=False),
    row("noise:0.001", "a", ber=0.0, present=True, recovered=True),
    row("noise:0.001", "b", ber=0.1, present=True, recovered=False),
    row("noise:0.001", "c", "refused"),
    row("noise:0.001", "d", "timeout"),
]


def test_lines_count_cases_by_outcome():
    mild, hard = summary(ROWS)
    assert mild == Line(
        scheme="toy",
        budget="standard",
        trial="marked",
        attack="noise:0.001",
        cases=4,
        refused=1,
        failed=1,
        present=2,
        recovered=1,
        ber=0.05,
    )
    assert hard == Line(
        scheme="toy",
        budget="standard",
        trial="marked",
        attack="noise:0.01",
        cases=1,
        refused=0,
        failed=0,
        present=0,
        recovered=0,
        ber=0.5,
    )


def test_a_line_without_a_reading_has_no_error_rate():
    (line,) = summary([ROWS[3]])
    assert line.ber is None
    assert line.to_dict()["cases"] == 1


def test_the_table_is_aligned():
    lines = as_table(summary(ROWS))
    assert len({len(line) for line in lines}) == 1
    assert lines[1].split() == [
        *("toy", "standard", "marked", "noise:0.001", "4", "1", "1", "50.0", "%", "25.0", "%", "5.0", "%"),
    ]
