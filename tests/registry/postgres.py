"""A PostgreSQL server of the tests' own, from the programs that Debian installs, on a socket in its own folder."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote

PROGRAMS = Path("/usr/lib/postgresql")
USER = "postgres"


def programs() -> Path | None:
    """Return the folder with initdb and postgres of the newest version, None where there is none."""
    found = [path.parent for path in PROGRAMS.glob("*/bin/initdb")]
    return max(found, key=lambda path: float(path.parent.name), default=None)


def why_not() -> str | None:
    """Return why no server can be started, None where one can."""
    if programs() is None:
        return "PostgreSQL is not installed (Debian: apt-get install postgresql)"
    if os.geteuid() == 0 and USER not in {entry.pw_name for entry in pwd.getpwall()}:
        return f"PostgreSQL does not run as root, and there is no user {USER}"
    return None


@contextmanager
def server() -> Iterator[str]:
    """Run a server; yields the address of its database `postgres`, which may make others."""
    home = Path(tempfile.mkdtemp(prefix="meshmark-pg-"))
    user: dict[str, object] = {}
    if os.geteuid() == 0:
        shutil.chown(home, USER, USER)
        user = {"user": USER, "group": USER, "extra_groups": []}

    def run(program: str, *arguments: str) -> None:
        command = [str(programs() / program), *arguments]
        with (home / "log.txt").open("ab") as log:
            subprocess.run(command, check=True, cwd=home, stdout=log, stderr=log, timeout=60, **user)

    data = str(home / "data")
    try:
        run("initdb", "-D", data, "-U", USER, "--auth=trust", "--no-sync", "-E", "UTF8", "--locale=C.UTF-8")
        settings = (
            f"-c listen_addresses= -c unix_socket_directories={home} -c fsync=off -c max_connections=40"
        )
        run("pg_ctl", "-D", data, "-w", "-o", settings, "start")
        try:
            yield f"postgresql://{USER}@/postgres?host={quote(str(home), safe='')}"
        finally:
            run("pg_ctl", "-D", data, "-m", "immediate", "stop")
    finally:
        shutil.rmtree(home, ignore_errors=True)
