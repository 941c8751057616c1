from __future__ import annotations

import re

import pytest

from meshmark.errors import OutputError
from meshmark.research.benchmark import reports as module
from meshmark.research.benchmark.figures.csv_files import read_results
from meshmark.research.benchmark.reports import write_reports
from tests.counting import some
from tests.research.benchmark.planted import planted_facts, planted_rows

ROWS = planted_rows(models=6, budgets=("standard",))
FACTS = planted_facts()


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "out"
    return folder, write_reports(ROWS, FACTS, folder)


def test_the_reports_are_where_it_says(written):
    folder, paths = written
    assert [path.name for path in paths] == ["report.html", "report.md", "results.csv", "summary.csv"]
    assert all(path.parent == folder and path.stat().st_size for path in some(paths))
    assert read_results((folder / "results.csv").read_text()) == sorted(ROWS, key=lambda row: row.case)


def test_the_same_rows_give_the_same_bytes_in_any_order(written, tmp_path):
    folder, _ = written
    write_reports(ROWS[::-1], FACTS, tmp_path)
    first = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.*")}
    again = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*.*")}
    assert first == again


def test_the_pictures_that_the_markdown_shows_exist(written):
    folder, _ = written
    text = (folder / "report.md").read_text()
    shown = re.findall(r"!\[[^\n]*\]\(([^)]+)\)", text)
    assert shown
    assert {folder / name for name in shown} == set((folder / "plots").iterdir())


def test_markdown_tables_are_aligned_where_cells_are_short(written):
    lines = (written[0] / "report.md").read_text().splitlines()
    tables = re.split(r"\n(?!\|)", "\n".join(lines))
    rows = [[line for line in block.splitlines() if line.startswith("|")] for block in tables]
    for table in some((table for table in rows if table), least=6):
        cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in table]
        assert len({len(line) for line in cells}) == 1
        for column in some(zip(*cells, strict=True)):
            widest = max(len(text.strip()) for text in column)
            assert (len({len(text) for text in column}) == 1) == (widest <= 44)
            assert (column[1].endswith(":")) == (column[0] != cells[0][0] and widest <= 44)


def test_the_markdown_names_the_command_of_every_table_and_plot(written):
    text = (written[0] / "report.md").read_text()
    assert text.count(f"Made by `{FACTS.command}`.") == len(re.findall(r"^### ", text, re.MULTILINE))


def test_without_matplotlib_there_are_reports_without_plots(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "has_matplotlib", lambda: False)
    html, md, *_ = write_reports(ROWS, FACTS, tmp_path)
    assert "pip install meshmark[research]" in html.read_text()
    assert "![" not in md.read_text()
    assert not (tmp_path / "plots").exists()


def test_a_folder_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(module, "has_matplotlib", lambda: False)
    with pytest.raises(OutputError, match=r"cannot make the folder .*file"):
        write_reports(ROWS[:40], FACTS, tmp_path / "file")
