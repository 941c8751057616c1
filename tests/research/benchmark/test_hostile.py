"""The check of hostile files calls what is wrong by its name, and goes on where it stopped."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

import pytest

from claims import hostile
from tests.io.binary_samples import binary_stl


@pytest.mark.parametrize(
    ("code", "out", "err", "fault"),
    [
        (0, "Marked", "", ""),
        (0, "Marked", "meshmark: one remark\nmeshmark: another\n", ""),
        (1, "Not marked", "", ""),
        (2, "", "meshmark: a.off is empty, expected a model file\n", ""),
        (2, "", "", "0 sentences"),
        (2, "", "meshmark: one\nmeshmark: two\n", "2 sentences"),
        (2, "", "meshmark: this is a bug in meshmark (ValueError); please report it\n", "bug"),
        (1, "", "Traceback (most recent call last):\n", "traceback"),
        (0, "", "RuntimeWarning: overflow encountered\n", "stray words"),
        (7, "", "meshmark: odd\n", "exit code 7"),
        (-signal.SIGSEGV, "", "", "crash by signal 11"),
        (-signal.SIGXCPU, "", "", "too slow"),
        (None, "", "", "hang"),
    ],
)
def test_faults_have_names(code: int | None, out: str, err: str, fault: str) -> None:
    assert hostile.fault_of(code, out, err) == fault


def test_a_folder_is_tried_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, store = tmp_path / "odd", tmp_path / "store.jsonl"
    folder.mkdir()
    (folder / "tiny.stl").write_bytes(binary_stl() + b"\n")
    (folder / "empty.off").write_bytes(b"")
    monkeypatch.setattr(sys, "argv", ["hostile", str(folder), "--store", str(store)])
    assert hostile.main() == 0
    assert "2 files, 4 commands, 0 with a fault" in capsys.readouterr().out
    rows = [json.loads(line) for line in store.read_text().splitlines()]
    assert [(Path(row["file"]).name, row["command"]) for row in rows] == [
        ("empty.off", "embed"),
        ("empty.off", "authenticate"),
        ("tiny.stl", "embed"),
        ("tiny.stl", "authenticate"),
    ]
    assert "is empty, expected a model file" in rows[0]["said"]

    def never(*_: object) -> None:
        raise AssertionError("what is in the store is not tried again")

    monkeypatch.setattr(hostile, "run", never)
    assert hostile.main() == 0
    rows[0]["fault"] = "bug"
    store.write_text("".join(json.dumps(row) + "\n" for row in rows))
    assert hostile.main() == 1
    assert "bug: embed" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", [*sys.argv, "--again"])
    with pytest.raises(AssertionError, match="in the store"):
        hostile.main()
