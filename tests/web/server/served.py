"""A server in a process of its own, as `meshmark serve` starts it, and what a client does with it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2 as httpx

START = "import sys, typer; from meshmark.web.server.serve import serve; sys.exit(typer.run(serve))"
OVER = ("done", "failed", "cancelled")


@dataclass(frozen=True, kw_only=True)
class Served:
    """A running server: its address, folders of keys and of temporary files, and its token where it has one."""

    url: str
    keys: Path
    temporary: Path
    process: subprocess.Popen[str]
    log: Path
    token: str = ""

    @property
    def key(self) -> Path:
        return self.keys / "studio.key"

    def client(self) -> httpx.Client:
        headers = {"authorization": f"Bearer {self.token}"} if self.token else {}
        return httpx.Client(base_url=self.url, timeout=120, trust_env=False, headers=headers)

    def begin(self, action: str, *files: Path, client: httpx.Client, **fields: Any) -> httpx.Response:
        """POST a job; fields that are paths are uploaded as well."""
        parts = [("files", (path.name, path.read_bytes())) for path in files]
        parts += [
            (name, (path.name, path.read_bytes())) for name, path in fields.items() if isinstance(path, Path)
        ]
        data = {name: value for name, value in fields.items() if not isinstance(value, Path)}
        return client.post("/api/jobs", data={"action": action, "key": "studio", **data}, files=parts)

    def run(self, action: str, *files: Path, **fields: Any) -> dict[str, Any]:
        """Run a job to its end and return its fields."""
        with self.client() as client:
            begun = self.begin(action, *files, client=client, **fields)
            assert begun.status_code == 202, begun.text
            return wait_for(begun.json()["id"], client)

    def save(self, job: Mapping[str, Any], kind: str, folder: Path) -> Path:
        """Download a file that a job made, and return where it is."""
        (found,) = [each for each in job["downloads"] if each["kind"] == kind]
        with self.client() as client:
            answer = client.get(found["url"])
        assert answer.status_code == 200, answer.text
        assert answer.headers["content-disposition"].startswith("attachment")
        path = folder / found["name"]
        path.write_bytes(answer.content)
        return path


def wait_for(identity: str, client: httpx.Client) -> dict[str, Any]:
    """Return the fields of a job when it is over."""
    while True:
        fields: dict[str, Any] = client.get(f"/api/jobs/{identity}", params={"wait": 20}).json()
        if fields["state"] in OVER:
            return fields


@contextmanager
def serving(folder: Path, *options: str, environment: Mapping[str, str] | None = None) -> Iterator[Served]:
    """Start a server on a free port, with everything in a folder, and end it as Ctrl-C does."""
    keys, temporary, log = folder / "keys", folder / "temporary", folder / "log"
    temporary.mkdir(exist_ok=True)
    given = {**os.environ, "TMPDIR": str(temporary), **(environment or {})}
    given.pop("MESHMARK_REGISTRY", None)
    with log.open("w") as out:
        process = subprocess.Popen(
            [sys.executable, "-c", START, "--port", "0", "--key-dir", str(keys), *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=given,
        )  # fmt: skip
        assert process.stderr is not None
        try:
            first = process.stderr.readline()
            out.write(first)
            out.flush()
            address = re.search(r"http://(\S+:\d+)/", first)
            assert address is not None, first + process.stderr.read()
            url = f"http://{address[1].replace('0.0.0.0', '127.0.0.1')}"
            token = process.stderr.readline().split()[-1] if "0.0.0.0" in address[1] else ""
            yield Served(url=url, keys=keys, temporary=temporary, process=process, log=log, token=token)
        finally:
            process.send_signal(signal.SIGINT)
            try:
                said = process.communicate(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
            out.write("".join(said))
