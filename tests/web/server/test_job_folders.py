"""Temporary folders: made, removed, and those of dead servers found."""

from __future__ import annotations

import subprocess
import sys

from meshmark.web.server.job_folders import PREFIX, job_folders, remove_stale

DIES = """
import os, sys
from pathlib import Path
from meshmark.web.server.job_folders import job_folders
with job_folders(Path(sys.argv[1])) as folder:
    (folder / "model.ply").write_text("secret")
    os._exit(9)
"""


def test_a_folder_is_for_its_owner_alone_and_is_removed_in_the_end(tmp_path):
    with job_folders(tmp_path) as folder:
        (folder / "a").mkdir()
        assert folder.stat().st_mode & 0o777 == 0o700
    assert list(tmp_path.iterdir()) == []


def test_the_folders_of_servers_that_died_are_removed_and_those_of_others_stay(tmp_path):
    subprocess.run([sys.executable, "-c", DIES, str(tmp_path)], check=False, timeout=60)
    (tmp_path / f"{PREFIX}link").symlink_to(tmp_path.parent)
    (left,) = (path for path in tmp_path.iterdir() if not path.is_symlink())
    assert (left / "model.ply").exists()
    with job_folders(tmp_path) as living:
        assert not left.exists()
        remove_stale(tmp_path)
        assert living.exists()
        with job_folders(tmp_path) as other:
            assert living.exists()
            assert other != living
    assert [path.name for path in tmp_path.iterdir()] == [f"{PREFIX}link"]
    assert tmp_path.parent.exists()
