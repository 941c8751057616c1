"""Copies for many recipients: one each, whatever interrupts it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import meshmark as mm
from meshmark.errors import OutputError, RegistryError
from meshmark.io.file_digest import digest_of_file
from meshmark.io.staging import Staging
from meshmark.registry import issuing
from meshmark.registry.issuing import Issue, Issued, check_rows, issue
from meshmark.registry.recipients import Recipient
from meshmark.registry.registry import Registry
from tests.counting import some
from tests.keys import KEY
from tests.marked import marked_pebble
from tests.registry.quick_embedding import embed_at_once
from tests.shapes import pebble

PEOPLE = [Recipient("Ann", "ann"), Recipient("Bob", "bob"), Recipient("Carl", "carl")]
FILES = ["ann.ply", "ann.ply.cert", "bob.ply", "bob.ply.cert", "carl.ply", "carl.ply.cert"]


@pytest.fixture
def registry(tmp_path: Path):
    made, _ = Registry.create(tmp_path / "issued.db")
    with made:
        yield made


@pytest.fixture
def plan(tmp_path: Path) -> Issue:
    (tmp_path / "out").mkdir()
    return Issue(
        mesh=mm.Mesh(*pebble(24)), name="in.ply", suffix=".ply", folder=tmp_path / "out", key=KEY,
        layers="ownership", resume=True,
    )  # fmt: skip


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(issuing, "embed_file", embed_at_once)


def digests(folder: Path) -> dict[str, str]:
    return {path.name: digest_of_file(path) for path in sorted(folder.iterdir()) if path.is_file()}


def told(copies: list[Issued]) -> list[tuple[str, bool]]:
    return [(each.recipient, each.made) for each in copies]


def test_each_recipient_gets_a_copy_with_a_certificate_and_a_row(plan, registry, quick):
    made = list(issue(plan, PEOPLE[:1], registry))
    assert told(made) == [("Ann", True)]
    (row,) = registry.copies()
    assert (row.id, row.recipient, row.path, row.state) == (made[0].id, "Ann", str(made[0].path), "issued")
    assert row.marked_digest == digest_of_file(made[0].path)
    beside = mm.Certificate.load(f"{made[0].path}.cert")
    assert json.dumps(beside.to_dict()) == registry.certificate(row.id, row.key)


def test_a_second_run_makes_what_is_missing_only(plan, registry, quick):
    first = list(issue(plan, PEOPLE[:2], registry))
    before = digests(plan.folder)
    again = list(issue(plan, PEOPLE, registry))
    assert told(again) == [("Ann", False), ("Bob", False), ("Carl", True)]
    assert [each.id for each in again[:2]] == [each.id for each in first]
    assert list(digests(plan.folder)) == FILES
    assert digests(plan.folder).items() >= before.items()


def test_what_was_deleted_is_made_again_as_it_was(plan, registry, quick):
    list(issue(plan, PEOPLE[:2], registry))
    before, rows = digests(plan.folder), registry.copies()
    (plan.folder / "ann.ply").unlink()
    (plan.folder / "bob.ply.cert").unlink()
    assert told(list(issue(plan, PEOPLE[:2], registry))) == [("Ann", True), ("Bob", False)]
    assert digests(plan.folder) == before
    assert registry.copies() == rows


def test_what_cannot_be_made_again_as_it_was_is_said(plan, registry, quick, monkeypatch):
    list(issue(plan, PEOPLE[:1], registry))
    (plan.folder / "ann.ply").unlink()

    def other(_mesh, out, _key, *, staging, **_options):
        staging.put(out, b"of another version")
        return marked_pebble(40, layers="ownership")

    monkeypatch.setattr(issuing, "embed_file", other)
    with pytest.raises(RegistryError, match="is another file than was issued"):
        list(issue(plan, PEOPLE[:1], registry))
    assert not (plan.folder / "ann.ply").exists()


def test_without_resume_what_is_there_is_refused_and_so_is_another_table(plan, registry, quick):
    list(issue(plan, PEOPLE[:1], registry))
    before = digests(plan.folder)
    with pytest.raises(
        OutputError, match="is in the registry already, as a copy for Ann; expected another folder"
    ):
        check_rows(replace(plan, resume=False), PEOPLE, registry)
    with pytest.raises(OutputError, match="is a copy for Ann, not for Zoe"):
        check_rows(plan, [Recipient("Zoe", "ann")], registry)
    (plan.folder / "bob.ply").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"bob\.ply exists already and is not in the registry"):
        check_rows(plan, PEOPLE, registry)
    (plan.folder / "ann.ply").write_bytes(b"changed since")
    with pytest.raises(OutputError, match="exists already"):
        list(issue(plan, PEOPLE[:1], registry))
    assert digests(plan.folder).items() >= {"ann.ply.cert": before["ann.ply.cert"]}.items()


def ended(function: Callable, *, before: bool = False, calls: int = 1) -> Callable:
    """Return a function that ends the process as `kill -9` does, before or after its so-manieth call."""
    left = [calls]

    def ending(*arguments: object, **options: object) -> object:
        left[0] -= 1
        if before and not left[0]:
            os._exit(9)
        result = function(*arguments, **options)
        if not left[0]:
            os._exit(9)
        return result

    return ending


MOMENTS = {
    "the id is held": (Registry, "reserve", {}),
    "the copy is being made": (Staging, "put", {}),
    "the copy is made": (Registry, "complete", {"before": True}),
    "the row is complete": (Registry, "complete", {}),
    "the certificate has its name": (Staging, "_take", {}),
    "the copy has its name": (Staging, "_take", {"calls": 2}),
    "the row is to be confirmed": (Registry, "confirm", {"before": True}),
    "the row is confirmed": (Registry, "confirm", {}),
    "the second copy is being made": (Staging, "put", {"calls": 3}),
}


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_run_that_was_killed_goes_on(plan, registry, quick, monkeypatch, moment):
    owner, name, how = MOMENTS[moment]
    place = registry.database.place
    child = os.fork()
    if child == 0:
        setattr(owner, name, ended(getattr(owner, name), **how))
        with Registry.open(place) as own:
            list(issue(plan, PEOPLE[:2], own))
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9, "it ended where it should"
    held = {row.recipient: row.id for row in registry.copies()}
    done = {row.recipient for row in registry.copies() if row.state == "issued"}
    assert {path.name for path in plan.folder.glob("*.ply")} <= {f"{name.lower()}.ply" for name in held}
    made = list(issue(plan, PEOPLE, registry))
    assert [each.recipient for each in made] == ["Ann", "Bob", "Carl"]
    assert {each.recipient for each in made if each.made} & done == set()
    rows = registry.copies()
    assert [(row.recipient, row.state) for row in rows] == [(each.name, "issued") for each in PEOPLE]
    assert {row.recipient: row.id for row in rows}.items() >= held.items(), "ids that were held are kept"
    assert list(digests(plan.folder)) == FILES
    for row in some(rows, least=3):
        assert digest_of_file(Path(row.path)) == row.marked_digest
        assert Path(row.path).read_text() == f"a copy with the id {row.id:x}"
