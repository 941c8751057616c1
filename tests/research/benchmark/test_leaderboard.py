"""The leaderboard: planted results in, their figures and their order out."""

from __future__ import annotations

import re

import pytest

from meshmark.errors import InputError
from meshmark.research.benchmark.figures.csv_files import results_csv
from meshmark.research.benchmark.leaderboard import leaderboard, main
from meshmark.research.benchmark.run.row import Case, Row

ATTACKS = ("none", "noise:0.001", "crop:0.1")
ERRORS = {"ncdg_lv": (0.0, 0.0, 0.5), "good": (0.0, 0.1, 0.0), "poor": (0.0, 0.4, 0.5)}


def rows(errors=ERRORS) -> list[Row]:
    made = []
    for name, shares in errors.items():
        for attack, share in zip(ATTACKS, shares, strict=True):
            for i in range(8):
                case = Case("robust", name, f"test/m{i}.ply", "standard", attack, "marked", 0)
                made.append(
                    Row(case=case, status="ok", points=900, size_class="500-2,500", split="test",
                        rms_over_diagonal=7e-4,
                        ber=share + 0.001 * i * (share > 0), present=share < 0.2, recovered=share == 0.0)
                )  # fmt: skip
    return made


def lines(page: str, title: str) -> dict[str, list[str]]:
    """Return the rows of a table of the page by their first cell."""
    table = page.split(f"### {title}\n")[1].split("\n\n")[0].strip()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return {line[0]: line[1:] for line in cells}


def test_schemes_are_ordered_by_exact_ids_and_then_by_bit_errors():
    page = leaderboard(rows())
    found = lines(page, "Schemes")
    assert [name.split(" ")[0] for name in found][2:] == ["good", "ncdg_lv", "poor"]
    assert found["good"][0] == "50 %"


def test_rows_in_which_ncdg_lv_does_not_lead_say_so():
    page = leaderboard(rows())
    assert "NCDG-LV does not lead in 1 of 3 rows" in page
    assert "behind by more than chance: crop 10 %." in page
    found = lines(page, "Attacks")
    assert found["crop 10 %"][-1].startswith(
        "behind good (0 % against 50.35 %, n 8): in 8 of 8 models it finds no mark"
    )
    assert found["noise 0.1 %"][-1] == "leads"
    assert found["untouched"][-1] == "level with good, poor"


def test_a_field_of_one_has_nobody_to_lead():
    assert "does not lead" not in leaderboard(rows({"ncdg_lv": (0.0, 0.0, 0.5)}))


def test_the_page_is_made_by_one_command(tmp_path, capsys):
    (tmp_path / "results.csv").write_text(results_csv(rows()))
    assert main([str(tmp_path / "results.csv"), str(tmp_path / "page.md")]) == 0
    page = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert re.search(r"Made by `python -m meshmark\.research\.benchmark\.leaderboard results\.csv`", page)
    assert main([str(tmp_path / "results.csv")]) == 0
    assert capsys.readouterr().out == page
    assert main([]) == 2


@pytest.mark.parametrize(("text", "sentence"), [("a,b\n1,2\n", "is no results.csv"), (None, "No such file")])
def test_a_file_that_is_none_is_said_to_be_so(tmp_path, capsys, text, sentence):
    if text:
        (tmp_path / "other.csv").write_text(text)
    assert main([str(tmp_path / "other.csv")]) == 2
    assert sentence in capsys.readouterr().err


def test_results_without_a_mark_are_refused():
    with pytest.raises(InputError, match="no marked model"):
        leaderboard([])
