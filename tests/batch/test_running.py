"""The loop of a batch, with an executor of this process."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from meshmark.batch.batch_id import batch_id
from meshmark.batch.results import Results
from meshmark.batch.running import run
from meshmark.batch.sources import Item
from meshmark.errors import OutputError
from meshmark.workers.worker_pool import Lost
from tests.keys import KEY


class Here:
    """Two workers that finish together; a model called "lost" loses its worker."""

    def __init__(self, messages: dict[str, str] | None = None) -> None:
        self.waiting: list[Item] = []
        self.most = 0
        self.messages = messages or {}

    @property
    def free(self) -> int:
        return 2 - len(self.waiting)

    @property
    def busy(self) -> int:
        return len(self.waiting)

    def submit(self, job: Item) -> None:
        self.waiting.append(job)
        self.most = max(self.most, len(self.waiting))

    def finished(self):
        ended, self.waiting = self.waiting, []
        return [(item, self._row(item)) for item in ended]

    def _row(self, item: Item):
        if item.name == "lost":
            return Lost(why="timeout", note="took longer than 5 s")
        row = {"model": item.name, "exit_code": 0}
        if item.name in self.messages:
            row["error"] = {"kind": "output", "message": self.messages[item.name], "file": None}
        return row


def models(*names: str):
    for name in names:
        yield Item(name=name, path=Path(name))


def test_each_model_gets_one_row_and_few_are_held_at_a_time(tmp_path):
    executor, told = Here(), []
    with Results(tmp_path, resume=False) as results:
        run(models("a", "b", "lost", "c", "d"), executor, results, told.append)
        run(models("a", "b", "lost", "c", "d", "e"), executor, results, told.append)
    assert [row["model"] for row in told] == ["a", "b", "lost", "c", "d", "e"]
    assert executor.most == 2
    assert told[2]["error"] == {"kind": "timeout", "message": "lost: took longer than 5 s", "file": "lost"}


def test_a_full_disk_stops_the_run_before_the_row_is_kept(tmp_path):
    full = Here({"b": f"cannot write out/b: {os.strerror(errno.ENOSPC)}"})
    with Results(tmp_path, resume=False) as results:
        with pytest.raises(OutputError, match="--resume goes on when there is space again"):
            run(models("a", "b", "c"), full, results, lambda _: None)
        assert results.done == {"a"}


def test_another_failure_to_write_is_a_row(tmp_path):
    odd = Here({"b": "cannot write out/b: File name too long"})
    with Results(tmp_path, resume=False) as results:
        run(models("a", "b", "c"), odd, results, lambda _: None)
        assert results.done == {"a", "b", "c"}


def test_ids_differ_by_key_name_and_file_and_are_the_same_in_every_run():
    first = batch_id(KEY, "a.ply", "00")
    assert first == 0xFD159F98C779EB81  # recorded: copies of earlier runs have this id
    others = [
        batch_id(KEY.derived("x"), "a.ply", "00"),
        batch_id(KEY, "b.ply", "00"),
        batch_id(KEY, "a.ply", "01"),
    ]
    assert len({first, *others}) == 4
