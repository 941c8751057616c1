"""The folder of keys: labels, fingerprints, and what is never told."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshmark.coding.keys import Key
from meshmark.errors import InputError, OutputError
from meshmark.web.server.key_folder import KeyFolder, ListedKey


@pytest.fixture
def folder(tmp_path) -> KeyFolder:
    made = KeyFolder(tmp_path / "keys")
    made.make()
    return made


def test_a_new_key_is_listed_by_its_label_and_fingerprint(folder):
    made = folder.create("studio")
    key = Key.load(folder.path / "studio.key")
    assert made == ListedKey(label="studio", fingerprint=key.fingerprint)
    assert folder.listed() == [made]
    assert folder.file_of("studio") == folder.path / "studio.key"
    assert (folder.path.stat().st_mode & 0o777, folder.file_of("studio").stat().st_mode & 0o777) == (
        0o700,
        0o600,
    )


def test_a_key_is_never_replaced(folder):
    folder.create("studio")
    before = (folder.path / "studio.key").read_bytes()
    with pytest.raises(OutputError, match="there is a key 'studio' already"):
        folder.create("studio")
    assert (folder.path / "studio.key").read_bytes() == before


def test_only_keys_are_listed_and_those_that_cannot_be_used_say_why(folder):
    folder.create("b")
    folder.create("a")
    (folder.path / "a.key").chmod(0o640)
    (folder.path / "notes.key").write_text("no key")
    (folder.path / "c.txt").write_bytes((folder.path / "b.key").read_bytes())
    (folder.path / "old.key").write_text("meshmark key 9\nunknown\n")
    first, second, third = folder.listed()
    assert [first.label, second.label, third.label] == ["a", "b", "old"]
    assert first.problem == "other users can read the key file a.key (mode 0640), expected 0600"
    assert (first.fingerprint, third.fingerprint, second.problem) == (None, None, None)


@settings(max_examples=40)
@given(st.text(max_size=80) | st.sampled_from(["..", "../a", "a/b", ".a", "-a", "a\n", "a\0", "A" * 65]))
def test_a_label_names_a_file_within_the_folder_or_is_refused(tmp_path_factory, label):
    folder = KeyFolder(tmp_path_factory.getbasetemp())
    try:
        place = folder._place(label)
    except InputError:
        place = folder.path / "refused.key"
    assert place.parent == folder.path
    assert place.name == f"{place.stem}.key"
    assert place.name[0].isalnum()
    assert len(place.name) <= 68


def test_a_label_without_a_key_is_told(folder):
    with pytest.raises(InputError, match="there is no key 'nobody'"):
        folder.file_of("nobody")
