"""The results file: whole lines only, each model once, and what a full disk leaves."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from meshmark.batch.results import RESULTS, Results
from meshmark.errors import InputError, OutputError


def row(name: str, **more: object) -> dict[str, object]:
    return {"model": name, "digest": "00", "exit_code": 0, **more}


def failure(name: str, kind: str) -> dict[str, object]:
    return row(name, error={"kind": kind, "message": "it failed", "file": name})


def lines(folder: Path) -> list[str]:
    return [json.loads(line)["model"] for line in (folder / RESULTS).read_text().splitlines()]


def test_rows_stay_and_an_earlier_run_is_gone_on_with_only_when_that_is_asked_for(tmp_path):
    with Results(tmp_path, resume=False) as results:
        results.add(row("a"))
    with pytest.raises(InputError, match="expected --resume to go on"):
        Results(tmp_path, resume=False)
    with Results(tmp_path, resume=True) as results:
        assert results.done == {"a"}
        results.add(row("b"))
    assert lines(tmp_path) == ["a", "b"]


def test_an_incomplete_last_line_is_dropped(tmp_path):
    with Results(tmp_path, resume=False) as results:
        results.add(row("a"))
        results.add(row("b"))
    whole = (tmp_path / RESULTS).read_bytes()
    for cut in (1, 10):
        (tmp_path / RESULTS).write_bytes(whole[:-cut])
        with Results(tmp_path, resume=True) as results:
            assert results.done == {"a"}
            results.add(row("b"))
        assert (tmp_path / RESULTS).read_bytes() == whole


def test_failures_that_may_pass_are_tried_again_and_others_are_not(tmp_path):
    with Results(tmp_path, resume=False) as results:
        for kind in ("killed", "timeout", "memory", "output", "registry", "format", "capacity", "bug"):
            results.add(failure(kind, kind))
    with Results(tmp_path, resume=True) as results:
        assert results.done == {"format", "capacity", "bug"}
    assert lines(tmp_path) == ["format", "capacity", "bug"]


def test_a_line_that_is_no_row_is_refused(tmp_path):
    (tmp_path / RESULTS).write_text('{"model": "a"}\n[]\n{"model": "b"}\n')
    with pytest.raises(InputError, match="line 2 is no result of a batch"):
        Results(tmp_path, resume=True)


def test_two_runs_do_not_share_a_folder(tmp_path):
    with Results(tmp_path, resume=False), pytest.raises(OutputError, match="another batch is running"):
        Results(tmp_path, resume=True)


def test_a_row_that_does_not_fit_on_the_disk_leaves_the_others(tmp_path, monkeypatch):
    with Results(tmp_path, resume=False) as results:
        results.add(row("a"))

        def full(_: int) -> None:
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(OutputError, match="No space left"):
                results.add(row("b"))
        assert lines(tmp_path) == ["a"]
        results.add(row("c"))
    assert lines(tmp_path) == ["a", "c"]


def test_outcomes_are_counted(tmp_path):
    with Results(tmp_path, resume=False) as results:
        for each in (
            row("a"), row("b", presence="absent"), row("c", verdict="altered"), row("d", matches=[]),
            row("e", matches=[1], presence="present"), failure("f", "format"), failure("g", "format"),
        ):  # fmt: skip
            results.add(each)
        assert results.counts() == {
            "marked": 1, "absent": 1, "altered": 1, "not traced": 1, "traced": 1, "failed: format": 2,
        }  # fmt: skip
