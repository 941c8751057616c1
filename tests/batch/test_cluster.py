"""A cluster as the executor of a batch: scheduler and workers of this process, which run a child for each model."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from meshmark.batch.cluster import Cluster
from meshmark.batch.results import Results
from meshmark.batch.running import run
from meshmark.batch.sources import Item, items
from meshmark.cli.batch_child import end_child, in_child
from meshmark.cli.batch_job import BatchCommand
from meshmark.errors import InputError
from meshmark.workers.worker_pool import Lost
from tests.keys import KEY

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def address():
    """The address of a scheduler with one worker of one thread."""
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0", protocol="tcp"
    ) as cluster:
        yield cluster.scheduler_address


def length(item: Item) -> dict[str, object] | Lost:
    if item.name == "broken":
        raise ValueError("no model")
    return Lost(why="timeout", note="slow") if item.name == "slow" else {"model": item.name, "exit_code": 0}


def test_models_are_handed_out_few_at_a_time_and_each_has_a_row(address, tmp_path):
    told = []
    with Results(tmp_path, resume=False) as results, Cluster(address, length) as cluster:
        assert cluster.free == 2
        names = ("a", "slow", "broken", *map(str, range(9)))
        run((Item(name=name, path=Path(name)) for name in names), cluster, results, told.append)
    kinds = {row["model"]: row["error"]["kind"] for row in told if "error" in row}
    assert kinds == {"slow": "timeout", "broken": "killed"}
    assert sorted(row["model"] for row in told) == sorted(names)


def test_a_child_answers_and_one_that_takes_too_long_is_ended(tmp_path):
    (tmp_path / "broken.ply").write_text("ply\nnothing\n")
    KEY.save(tmp_path / "my.key")
    command = BatchCommand(name="extract", key=str(tmp_path / "my.key"), out=str(tmp_path))
    (item,) = items(str(tmp_path / "broken.ply"), tmp_path / "out")
    lost = in_child(command, 0.01, 1000, item)
    assert lost == Lost(why="timeout", note="took longer than 0.01 s")
    rows = [in_child(command, 60.0, 1000, item) for _ in range(2)]
    assert [row["error"]["kind"] for row in rows] == ["format", "format"]
    assert end_child() == -signal.SIGKILL
    assert end_child() == 0


def test_a_scheduler_that_does_not_answer_is_refused(monkeypatch):
    monkeypatch.setattr("meshmark.batch.cluster._PATIENCE", 1)
    with pytest.raises(InputError, match="does not answer"):
        Cluster("tcp://127.0.0.1:1", length)
