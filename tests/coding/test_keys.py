from __future__ import annotations

import copy
import dataclasses
import hashlib
import hmac
import json
import pickle
import re
import stat
from pathlib import Path

import pytest

from meshmark.coding.keys import Key, is_key_file
from meshmark.errors import InputError, KeyFileError, OutputError
from tests.counting import some

SECRET = bytes(range(32))
HEX = SECRET.hex()
GOOD = f"meshmark key 1\n{HEX}\n"


def test_a_saved_key_is_read_back(tmp_path: Path) -> None:
    key = Key.generate()
    key.save(tmp_path / "a.key")
    assert Key.load(tmp_path / "a.key") == key
    assert Key.load(str(tmp_path / "a.key")).subkey("x") == key.subkey("x")


def test_the_file_has_a_header_and_64_hexadecimal_digits_and_is_private(tmp_path: Path) -> None:
    path = tmp_path / "a.key"
    Key(SECRET).save(path)
    assert path.read_text() == GOOD
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert list(tmp_path.iterdir()) == [path]


def test_an_existing_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a.key"
    path.write_text("something else")
    with pytest.raises(OutputError, match="exists already"):
        Key(SECRET).save(path)
    assert path.read_text() == "something else"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_to_nowhere_counts_as_existing(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with pytest.raises(OutputError, match="exists already"):
        Key(SECRET).save(tmp_path / "link")
    assert not (tmp_path / "target").exists()


def test_a_missing_folder_is_one_sentence_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot write the key file"):
        Key(SECRET).save(tmp_path / "missing" / "a.key")
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OutputError, match="No space left on device"):
        Key(SECRET).save(tmp_path / "a.key")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "content",
    [
        "",
        HEX,
        HEX + "\n",
        GOOD + "\n",
        GOOD[:-1],
        GOOD[:-2] + "\n",
        GOOD.upper(),
        GOOD.replace("1\n", "2\n", 1),
        GOOD.replace("\n", "\r\n"),
        "\ufeff" + GOOD,
        "meshmark key 1\n" + "g" * 64 + "\n",
        "meshmark key 1\n" + "\u0661" * 64 + "\n",
        GOOD * 1000,
    ],
)
def test_anything_else_is_refused_without_quoting_it(tmp_path: Path, content: str) -> None:
    path = tmp_path / "b.key"
    path.write_bytes(content.encode())
    with pytest.raises(KeyFileError, match="is not a meshmark key") as caught:
        Key.load(path)
    assert HEX[:8] not in str(caught.value).lower()
    assert caught.value.__cause__ is None
    assert "\n" not in str(caught.value)


def test_a_missing_file_or_a_folder_is_one_sentence(tmp_path: Path) -> None:
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(KeyFileError, match="cannot read the key file"):
            Key.load(path)


def test_the_secret_does_not_leak() -> None:
    key = Key(SECRET)
    shown = f"{key} {key!r} {key!s} {[key]} {{'k': key}}" + format(key)
    assert HEX[:8] not in shown
    assert repr(SECRET)[2:10] not in shown
    assert not dataclasses.is_dataclass(key)
    assert not hasattr(key, "__dict__")
    for protocol in some(range(pickle.HIGHEST_PROTOCOL + 1)):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(key, protocol)
    with pytest.raises(TypeError):
        json.dumps(key)


def test_a_key_cannot_be_changed() -> None:
    key = Key(SECRET)
    with pytest.raises(AttributeError):
        key._secret = bytes(32)
    with pytest.raises(AttributeError):
        del key._secret
    assert copy.copy(key) is key
    assert copy.deepcopy(key) is key


def test_keys_are_equal_when_their_secrets_are() -> None:
    assert Key(SECRET) == Key(SECRET)
    assert hash(Key(SECRET)) == hash(Key(SECRET))
    assert Key(SECRET) != Key(bytes(32))
    assert Key(SECRET) != SECRET
    assert Key.generate() != Key.generate()


@pytest.mark.parametrize("secret", [b"", bytes(31), bytes(33), "0" * 32, bytearray(32)])
def test_a_secret_of_another_size_or_kind_is_refused(secret: object) -> None:
    with pytest.raises(InputError, match="32 bytes"):
        Key(secret)  # type: ignore[arg-type]


def test_a_subkey_is_the_documented_hmac() -> None:
    expected = hmac.new(SECRET, b"meshmark subkey 1\0cells", hashlib.sha256).digest()
    assert Key(SECRET).subkey("cells") == expected
    assert len({Key(SECRET).subkey(p) for p in ("a", "b", "ab", "a\0")}) == 4
    with pytest.raises(InputError, match="purpose"):
        Key(SECRET).subkey("")


def test_the_fingerprint_names_the_key_in_public_and_tells_nothing_of_it() -> None:
    key = Key(SECRET)
    assert key.fingerprint == Key(SECRET).fingerprint == key.subkey("public fingerprint")[:8].hex()
    assert re.fullmatch("[0-9a-f]{16}", key.fingerprint)
    assert key.fingerprint not in HEX
    assert len({Key(bytes([n]) * 32).fingerprint for n in range(100)}) == 100


def test_a_key_file_is_known_by_its_first_line(tmp_path: Path) -> None:
    Key(SECRET).save(tmp_path / "a.key")
    (tmp_path / "broken").write_text("meshmark key 1\nnothing\n")
    (tmp_path / "none").write_text("meshmark keys")
    assert [is_key_file(tmp_path / name) for name in ("a.key", "broken", "none", "absent", ".")] == [
        True,
        True,
        False,
        False,
        False,
    ]


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o604, 0o660])
def test_a_key_that_other_users_can_read_is_refused_unless_forced(tmp_path, mode):
    path = tmp_path / "a.key"
    key = Key.generate()
    key.save(path)
    path.chmod(mode)
    with pytest.raises(KeyFileError, match=rf"other users can read .*mode {mode:04o}\), expected 0600"):
        Key.load(path)
    assert Key.load(path, force=True) == key
    path.chmod(0o400)
    assert Key.load(path) == key


def test_a_derived_key_is_that_of_rfc_5869():
    """HKDF with SHA-256 and no salt, one block, written out."""
    import hashlib
    import hmac

    secret = bytes(range(32))
    pseudorandom = hmac.digest(bytes(32), secret, hashlib.sha256)
    block = hmac.digest(pseudorandom, "meshmark derived key 1\0Zoë".encode() + b"\1", hashlib.sha256)
    assert Key(secret).derived("Zoë") == Key(block)
    assert Key(secret).derived("a") != Key(secret).derived("b")
    with pytest.raises(InputError, match="needs a label"):
        Key(secret).derived("")
