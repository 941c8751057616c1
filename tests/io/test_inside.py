"""Files that a model names are read within its folder, and through no link."""

from __future__ import annotations

import pytest

from meshmark.io.inside import head_inside, is_inside, read_inside


@pytest.fixture
def home(tmp_path):
    (tmp_path / "home" / "sub").mkdir(parents=True)
    (tmp_path / "home" / "sub" / "a.bin").write_bytes(b"inside")
    (tmp_path / "home" / ".ssh").mkdir()
    (tmp_path / "home" / ".ssh" / "id").write_bytes(b"secret")
    (tmp_path / "secret").write_bytes(b"secret")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "a.bin").write_bytes(b"secret")
    (tmp_path / "home" / "link.bin").symlink_to(tmp_path / "secret")
    (tmp_path / "home" / "here.bin").symlink_to(tmp_path / "home" / "sub" / "a.bin")
    (tmp_path / "home" / "linked").symlink_to(tmp_path / "other")
    return tmp_path / "home"


def test_a_file_below_the_folder_is_read(home, tmp_path):
    assert read_inside(home, "sub/a.bin", 6) == b"inside"
    assert head_inside(home, "sub/a.bin", 2) == b"in"
    assert is_inside(home, "sub/a.bin")
    (tmp_path / "way").symlink_to(home)  # the folder itself may be reached as the user likes
    assert read_inside(tmp_path / "way", "sub/a.bin", 6) == b"inside"


@pytest.mark.parametrize(
    "name",
    [
        "link.bin",
        "here.bin",
        "linked/a.bin",
        "../secret",
        "sub/../../secret",
        ".ssh/id",
        "sub",
        "none",
        "",
        "/etc/passwd",
    ],
)
def test_nothing_else_is(home, name):
    assert not is_inside(home, name)
    assert head_inside(home, name, 4) == b""
    with pytest.raises(OSError, match=r"."):
        read_inside(home, name, 100)


def test_a_file_that_is_too_long_is_refused(home):
    with pytest.raises(OSError, match="longer than 5 bytes"):
        read_inside(home, "sub/a.bin", 5)
