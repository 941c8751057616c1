"""A registry on SQLite and on PostgreSQL: the same tests for both."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import replace

import pytest

from meshmark.errors import InputError, RegistryError
from meshmark.registry.registry import Registry
from tests.counting import some
from tests.registry.records_samples import KEY, OTHER_KEY, copy, original


def issued(registry: Registry, made, certificate: str = "{}"):
    """Enter a copy in its three steps and return it as it is kept."""
    registry.reserve(
        original(made.original_name), made.key, id=made.id, recipient=made.recipient, path=made.path
    )
    registry.complete(made, certificate)
    registry.confirm(made.id, made.key)
    return replace(made, state="issued")


def test_an_empty_registry_has_nothing(registry):
    assert registry.copies() == []
    assert registry.originals() == []
    assert registry.copies_with_id(1) == []
    assert registry.shapes(KEY) == []


def test_what_goes_in_comes_out(registry):
    made = [issued(registry, copy(number, f"Ann {number}")) for number in (1, 2**64 - 1, 3)]
    assert registry.copies() == made
    assert registry.copies_with_id(2**64 - 1) == [made[1]]
    assert registry.copies_with_id(2**64 - 1, OTHER_KEY) == []
    assert registry.copies(recipient="Ann 3") == [made[2]]
    assert registry.originals() == [original()]
    assert registry.certificate(3, KEY) == "{}"


def test_an_id_is_pending_until_its_file_is_there(registry):
    held = registry.reserve(original(), KEY, recipient="Bob", path="b.ply")
    (pending,) = registry.copies()
    assert (pending.id, pending.state, pending.recipient, pending.mark) == (held, "pending", "Bob", None)
    registry.complete(copy(held, "ignored"), "{}")
    (complete,) = registry.copies()
    assert (complete.state, complete.recipient, complete.path) == ("pending", "Bob", "b.ply")
    registry.confirm(held, KEY)
    assert registry.copies()[0].state == "issued"
    registry.withdraw(held, KEY)
    assert len(registry.copies()) == 1, "what is issued is not given up"


def test_an_id_that_is_given_up_is_free_again(registry):
    registry.reserve(original(), KEY, id=5, recipient="Bob")
    registry.withdraw(5, KEY)
    assert registry.copies() == []
    registry.reserve(original("other.ply"), KEY, id=5, recipient="Ann")


def test_one_id_is_one_copy_of_a_key(registry):
    issued(registry, copy(7, "Ann"))
    with pytest.raises(
        RegistryError, match=r"the id 0000000000000007 is in the registry already \(issued to Ann"
    ):
        registry.reserve(original(), KEY, id=7, recipient="Bob")
    registry.reserve(original(), OTHER_KEY, id=7, recipient="Bob")
    assert [each.recipient for each in registry.copies_with_id(7)] == ["Ann", "Bob"]


def test_the_very_copy_that_was_left_pending_is_taken_over(registry):
    for path in ("a.ply", None):
        first = registry.reserve(original(), KEY, id=8 + bool(path), recipient="Ann", path=path)
        assert registry.reserve(original(), KEY, id=first, recipient="Ann", path=path) == first
    with pytest.raises(RegistryError, match="pending to Ann"):
        registry.reserve(original(), KEY, id=9, recipient="Ann", path="other.ply")
    assert len(registry.copies()) == 2


def test_steps_out_of_turn_are_refused(registry):
    with pytest.raises(RegistryError, match="no longer holds the id 0000000000000001"):
        registry.confirm(1, KEY)
    with pytest.raises(RegistryError, match="no longer holds"):
        registry.complete(copy(1), "{}")


@pytest.mark.parametrize("name", ["Ann O'Neill; DROP TABLE copies", "Zoë 😀", "a\nb", "%s {0}", "\udcff"])
def test_any_name_is_kept(registry, name):
    registry.reserve(original(), KEY, id=1, recipient=name)
    kept = registry.copies()[0].recipient
    assert kept == name.encode("utf-8", "backslashreplace").decode()


def test_a_name_that_no_database_holds_is_refused(registry):
    with pytest.raises(InputError, match="zero character"):
        registry.reserve(original(), KEY, recipient="a\0b")
    assert registry.copies() == []


def test_the_ways_in_which_copies_are_marked_come_commonest_first(registry):
    for number, step in enumerate((0.1, 0.05, 0.05, 0.2), start=1):
        issued(registry, copy(number, step=step), f'"{number}"')
    registry.reserve(original(), KEY, id=99)
    assert registry.typical_certificates(original().digest, KEY, 3) == ['"2"', '"1"', '"4"']
    assert registry.typical_certificates(original().digest, KEY, 1) == ['"2"']
    assert registry.ids(original().digest, KEY) == (1, 2, 3, 4, 99)
    assert registry.ids(original().digest, OTHER_KEY) == ()


def test_shapes_are_those_of_the_originals_of_a_key(registry):
    registry.reserve(original("a", b"shape"), KEY, id=1)
    registry.reserve(original("b"), OTHER_KEY, id=1)
    assert registry.shapes(KEY) == [(original("a").digest, "a", b"shape")]
    assert registry.original(original("a").digest) == original("a", b"shape")
    assert registry.original("0" * 64) is None


def test_a_registry_is_made_once_and_what_it_holds_stays(registry, place):
    issued(registry, copy(1))
    again, changed = Registry.create(place)
    with again:
        assert not changed
        assert len(again.copies()) == 1


WRITERS, COPIES, KILLS = 8, 8, 2
# Processes that share nothing but the registry; they are forked, as importing takes longer than all they do.
WRITER = """
import os, sys
from meshmark.registry.registry import Registry
from tests.registry.records_samples import KEY, copy, original
place, writers, copies = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
Registry.create  # imported before the processes part
import alembic.operations, alembic.runtime.migration, alembic.script, psycopg
children = []
for writer in range(writers):
    child = os.fork()
    if child == 0:
        registry, changed = Registry.create(place)
        for number in range(copies):
            held = registry.reserve(original(f"{number}.ply"), KEY, recipient=f"{writer}", path=f"{number}")
            registry.complete(copy(held, "", f"{number}.ply"), "{}")
            registry.confirm(held, KEY)
            os.write(1, f"{writer} {held}\\n".encode())
        os._exit(0)
    children.append(child)
failed = [child for child in children if os.waitpid(child, 0)[1]]
sys.exit(len(failed))
"""


def writing(place: str, writers: int, copies: int) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", WRITER, place, str(writers), str(copies)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)


def test_eight_writers_lose_nothing_and_double_nothing(place):
    """They make the registry at once, too, and enter the same originals."""
    process = writing(place, WRITERS, COPIES)
    told = [line.split() for line in process.communicate(timeout=120)[0].splitlines()]
    assert process.returncode == 0
    with Registry.open(place) as registry:
        found = registry.copies()
        assert len(registry.originals()) == COPIES
    assert {each.state for each in found} == {"issued"}
    assert sorted((each.recipient, str(each.id)) for each in found) == sorted(map(tuple, told))
    assert Counter(writer for writer, _ in told) == {f"{number}": COPIES for number in range(WRITERS)}


def test_writers_that_are_killed_lose_nothing_that_they_told(place):
    Registry.create(place)[0].database.close()
    told: list[str] = []
    for number in some(range(KILLS), least=KILLS):
        process = writing(place, 2, 100_000)
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(5 + 7 * number)]
        os.killpg(process.pid, signal.SIGKILL)
        lines += process.stdout.read().splitlines(keepends=True)
        process.wait()
        process.stdout.close()
        told += [line.split()[1] for line in lines if line.endswith("\n")]
    with Registry.open(place) as registry:
        kept = {str(each.id) for each in registry.copies() if each.state == "issued"}
        assert set(told) <= kept
        assert len(kept) <= len(told) + 2 * KILLS, (
            "each may have ended between its last row and telling of it"
        )
        registry.reserve(original(), KEY, recipient="afterwards")
