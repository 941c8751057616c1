"""The paper's tables: its numbers as printed, and measured ones with planted values."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.research.ablation.region_maps import CHOICES
from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.paper.classes import classes_of
from meshmark.research.benchmark.paper.compared import standing, tables
from meshmark.research.benchmark.paper.measured import Group, Measured
from meshmark.research.benchmark.paper.published_claims import ABLATION, CLAIMED, CLASSES, DOUBTS, TABLES
from meshmark.research.benchmark.paper.rates import rate_parts
from meshmark.research.benchmark.paper.section import paper_section
from meshmark.research.benchmark.paper.watermark import watermark_parts, watermark_psnr
from meshmark.research.benchmark.reports import write_reports
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.row import Case, Row
from meshmark.research.benchmark.run.suites import SUITES, cases
from tests.counting import some
from tests.research.benchmark.planted import planted_facts

MODELS = [f"test/m{i}.off" for i in range(12)]
BER = {"ncdg_lv": 0.0, "lsb": 0.5, "mdaqim": 0.25}


def planted(schemes=tuple(BER)) -> list[Row]:
    """Return rows of the suite; bit errors are those of `BER` under every attack but "none", which leaves none."""
    rows = []
    for i, model in enumerate(MODELS):
        for scheme in schemes:
            for case in cases("paper", scheme, model, 0):
                rows.append(_row(case, i))
    return rows


def _row(case: Case, i: int) -> Row:
    common = {"points": 400 + 300 * i, "size_class": "< 500" if i == 0 else "500-2,500", "split": "test"}
    if i == 0 and case.scheme == "ncdg_lv":
        return Row(case=case, status="refused", note="too small", **common)
    wrong = BER[case.scheme] if case.attack != "none" else 0.0
    found = case.trial == "marked" and wrong < 0.25
    return Row(
        case=case, status="ok", **common, psnr_db=62.0 + i, paper_psnr_db=58.0 + i, attacked_psnr_db=40.0,
        rms_over_diagonal=7e-4, ber=wrong if case.trial == "marked" else 0.5, present=found,
        recovered=found and not wrong,
    )  # fmt: skip


@pytest.fixture
def labelled(tmp_path):
    lines = [f"m{i},{i},Something,{CLASSES[i] if i < 10 else ''}" for i in range(12)]
    (tmp_path / "labels.csv").write_text("\n".join(["name,psb_id,infomr_class,paper_class", *lines]))
    (tmp_path / "test").mkdir()
    return tmp_path / "test"


def measured() -> Measured:
    return Measured(planted(), {f"test/m{i}.off": CLASSES[i] for i in range(10)})


@pytest.mark.parametrize("number", [2, 3])
def test_printed_averages_are_those_of_the_printed_rows(number):
    assert np.mean(TABLES[number].rows, axis=0) == pytest.approx(TABLES[number].average, abs=1e-9)


def test_the_doubts_are_true_of_the_printed_numbers():
    first, fourth = (np.array(TABLES[number].rows)[:9, :3] for number in (1, 4))
    shift = np.round(first - fourth, 2)
    assert shift.size == 27
    assert int(((shift >= 5.02) & (shift <= 5.03)).sum()) == 26
    errors = np.array(TABLES[2].rows)
    assert (errors[7:, 1] < errors[7:, 0]).all(), "Laplace-Beltrami is ahead in models 8 to 10"
    assert set(DOUBTS) >= {claims.name for claims in TABLES.values()}
    assert all(len(claims.rows) == len(CLASSES) for claims in some(TABLES.values()))


def test_classes_come_from_a_table_of_labels(labelled):
    found = classes_of(labelled, ["deep/m3.off.xz", "m11.off", "other.off"])
    assert found == {"deep/m3.off.xz": CLASSES[3]}


def test_classes_come_from_the_files_of_the_original(tmp_path):
    text = "PSB 1\n5 4\n\nanimal 0 0\n\nquadruped animal 0\nhorse quadruped 2\n7\n8\n"
    text += "dining_table 0 1\n9\nplane 0 1\n3\n"
    (tmp_path / "classification").mkdir()
    (tmp_path / "classification" / "test.cla").write_text(text)
    models = [f"db/0/m{i}/m{i}.off" for i in (3, 7, 8, 9)]
    assert classes_of(tmp_path, models) == {models[1]: "horse", models[2]: "horse", models[3]: "table"}


def test_a_folder_that_tells_no_classes_gives_none(tmp_path):
    assert classes_of(tmp_path, ["m1.off"]) == {}
    assert classes_of(tmp_path / "nowhere", ["m1.off"]) == {}


def test_groups_are_classes_all_and_sizes():
    labels = [group.label for group in measured().groups()]
    assert labels[0] == "Model1 (rabbit)"
    assert labels[10:] == ["all models", "< 500 points", "500-2,500 points"]


def test_tables_stand_beside_the_claims():
    found = {table.title: table for table in tables(measured())}
    (smoothed,) = (t for name, t in found.items() if name.startswith("Table 3") and "0.1" in name)
    assert smoothed.columns[: 1 + len(CLAIMED)] == ("models", *(f"{t}, claimed %" for t in CLAIMED.values()))
    whole = next(row for row in smoothed.rows if row[0].text == "all models")
    assert [cell.text for cell in whole[1:5]] == ["7.785", "8.79", "9.645", "8.345"]
    assert whole[5].text == "0 %"
    assert "n 11" in whole[5].small, "one was refused"
    assert [cell.text for cell in whole[6:8]] == ["25 %", "50 %"]
    assert whole[-1].text == "leads"
    rabbit = smoothed.rows[0]
    assert (rabbit[5].text, rabbit[-1].text) == ("–", "–"), "the rabbit was refused by NCDG-LV"
    (psnr,) = (t for name, t in found.items() if name.startswith("Table 1") and "20 log10" in name)
    assert next(row for row in psnr.rows if row[0].text == "Model2 (vase)")[5].text == "63.00"
    assert all(
        table.note.startswith(f"Doubts about the paper's {table.title[:7]}") for table in some(found.values())
    )


def test_whoever_leads_is_told_and_why():
    group = Group(label="all", models=frozenset("abcdef"))
    own = dict.fromkeys("abcdef", 0.4)
    better, same = {**dict.fromkeys("abcde", 0.1), "f": 0.11}, dict(own)
    lost = {**dict.fromkeys("abc", 1.0), **dict.fromkeys("def", 0.0)}
    found = standing({"ncdg_lv": own, "lsb": better, "mdaqim": same}, group, "%", lost)
    assert found.behind
    assert found.clearly
    assert "behind lsb (10.17 % against 40 %, n 6): in 3 of 6 models it finds no mark" in found.words
    assert "level with 3D-MDAQIM" in found.words
    noisy = dict(zip("abcdef", (0.0, 0.8, 0.0, 0.9, 0.0, 0.5), strict=True))
    chance = standing({"ncdg_lv": own, "lsb": noisy}, group, "%", lost)
    assert chance.behind
    assert not chance.clearly
    assert "within chance" in chance.words
    assert standing({"ncdg_lv": better, "lsb": own}, group, "%", lost).words == "leads"
    guesses = {"ncdg_lv": dict.fromkeys("abcdef", 0.51), "lsb": dict.fromkeys("abcdef", 0.47)}
    assert standing(guesses, group, "%", lost).words == "level with lsb (both guess)"
    assert standing({"ncdg_lv": better, "lsb": own}, group, "dB", lost).clearly, "more decibels are better"
    assert standing({"ncdg_lv": own, "ncdg_lv_certificate": better}, group, "%", lost).words == "–"
    assert standing({"lsb": own}, group, "%", lost).words == "–"


@pytest.mark.parametrize(("share", "decibels"), [(0.5, 3.0103), (0.1, 10.0), (1.0, 0.0), (0.0, np.inf)])
def test_the_psnr_of_bits_is_that_of_their_picture(share, decibels):
    found = watermark_psnr(Estimate(share, 0.0, 1.0, 3))
    assert found.value == pytest.approx(decibels, abs=1e-4)
    assert (found.low, found.high) == (0.0, np.inf)


def test_figures_11_to_13_have_the_papers_strengths():
    parts = watermark_parts(measured(), pictures=False)
    assert [len(table.rows) for table in parts] == [6, 3, 3]
    row = parts[1].rows[0]
    assert row[0].text == "Gaussian noise 1 %"
    assert [cell.text for cell in row[1:4]] == ["∞", "6.02", "3.01"]
    assert all(cell.text == "40.00" for cell in some(row[4:]))


def test_missed_and_found_add_up_to_all():
    missed, found = rate_parts(measured(), pictures=False)
    last = {name: (missed.rows[-1][i].text, found.rows[-2][i].text) for i, name in enumerate(BER, 1)}
    assert missed.rows[-1][0].text == "first 12"
    assert last["ncdg_lv"] == ("0.0 %", "100.0 %")
    mdaqim = missed.columns.index("3D-MDAQIM")
    assert missed.rows[-1][mdaqim].text == "100.0 %", "it finds none of the attacked"
    assert found.rows[-2][mdaqim].text == f"{100 / 14:.1f} %", "it finds the untouched, one of 14"
    assert found.rows[-1][0].text == "false positive rate"


def planted_probes() -> dict[Probe, Outcome]:
    regions = {"balance": 1.5, "agreement": 0.75, "seconds": 0.02, "altered": [1.0, 0.0, 0.0],
               "network": [3.0, -2.0, 0.5], "rule": [-1.0, -2.0, -3.0], "called": [0.25]}  # fmt: skip
    choices = {m.map: regions for m in CHOICES}
    bits = {
        "errors": [0.1, 0.2],
        "information": [0.5, 0.6],
        "decoded": [1.0, 1.0],
        "decoded_half": [0.0, 1.0],
    }
    return {
        Probe(kind="salient points", model=MODELS[1], seed=0): Outcome(
            status="ok", figures={"nc_dgg": {"seconds": 0.004, "points": 9}}
        ),
        Probe(kind="regions", model=MODELS[1], seed=0): Outcome(status="ok", figures=choices),
        Probe(kind="regions", model=MODELS[2], seed=0): Outcome(status="refused", note="too small"),
        Probe(kind="carriers", model=MODELS[1], seed=0): Outcome(
            status="ok", figures={"network": bits, "rule": bits}
        ),
    }  # fmt: skip


def test_the_section_has_all_tables_figures_and_modules(labelled):
    facts = planted_facts()
    assert not paper_section(planted(), facts, {}, pictures=False).parts, "of another suite"
    facts = type(facts)(**{**facts.to_dict(), "suite": "paper", "data": str(labelled)})
    section = paper_section(planted(), facts, planted_probes(), pictures=True)
    titles = [part.title for part in section.parts]
    for name in (*(f"Table {i}" for i in (1, 2, 3, 4)), *(f"Figure {i}" for i in (7, 9, 10, 11, 12, 13))):
        assert any(title.startswith(f"{name}:") for title in titles), name
    assert sum(title.startswith("Ablation") for title in titles) == 5
    by = {part.title: part for part in section.parts}
    assert [row[0].text for row in by["Ablation: the paper's table"].rows] == [
        line.modules for line in ABLATION
    ]
    verdicts = by["Ablation: extraction, verdicts on regions"].rows
    assert [cell.text for cell in verdicts[0][2:]] == ["3", "1.0000", "0 %", "50 %"]
    assert [cell.text for cell in verdicts[1][2:]] == ["3", "1.0000", "100 %", "0 %"]
    assert "m1" not in by["Models that could be marked"].columns
    assert by["Models that could be marked"].rows[0][1].text == "11 of 12"


def test_the_report_holds_the_section(labelled, tmp_path):
    facts = planted_facts()
    facts = type(facts)(**{**facts.to_dict(), "suite": "paper", "data": str(labelled)})
    write_reports(planted(), facts, tmp_path / "out", planted_probes())
    text = (tmp_path / "out" / "report.md").read_text()
    assert "Table 4 " not in text.split("## ")[0]
    assert "Doubts about the paper's Table 4" in text
    for line in some(line for line in text.splitlines() if line.startswith("![")):
        assert (tmp_path / "out" / line.split("](")[1].rstrip(")")).exists()


def test_the_suite_is_the_papers():
    assert SUITES["paper"].schemes[0] == "ncdg_lv"
    attacks = {case.attack for case in cases("paper", "ncdg_lv", "m", 0)}
    for strength in (
        "smoothing:5",
        "smoothing:10",
        "smoothing:15",
        "gaussian:0.01",
        "gaussian:0.05",
        "crop:0.09",
    ):
        assert strength in attacks
