"""A process that runs one command of the command line for the server, and ends: `python -m` this module.

It loads what commands need, says so, and waits for one line on standard input: the job. Standard output carries
lines of JSON: {"ready"}, {"stage"}, {"remark"}, and at last {"code", "words", "answer", "view"}. The pipe from the
server is watched: where the server is gone, so is this process.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import sys
import threading
from collections.abc import Mapping
from typing import Any

from meshmark.errors import MeshmarkError

__all__ = ["main"]

_PREFIX = "meshmark: "


class _Reporter:
    """Hands what the command says to the server, and keeps its answer."""

    def __init__(self, descriptor: int) -> None:
        self._stream = os.fdopen(descriptor, "w", encoding="utf-8")
        self.words, self.fields = "", {}  # type: str, dict[str, Any]

    def send(self, **fields: Any) -> None:
        self._stream.write(json.dumps(fields) + "\n")
        self._stream.flush()

    def stage(self, label: str) -> None:
        self.send(stage=label)

    def remark(self, line: str) -> None:
        self.send(remark=line.removeprefix(_PREFIX))

    def answer(self, words: str, fields: Mapping[str, Any]) -> None:
        self.words, self.fields = words, dict(fields)


def main() -> int:
    """Run one command and report it."""
    report = _Reporter(os.dup(sys.stdout.fileno()))
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    _load()
    report.send(ready=True)
    line = sys.stdin.readline()
    if not line:
        return 0
    threading.Thread(target=_end_with_the_server, daemon=True).start()
    job = json.loads(line)
    os.chdir(job["folder"])
    _limit(job)
    if job["registry"]:
        os.environ["MESHMARK_REGISTRY"] = job["registry"]
    from meshmark.cli.listening import heard_by
    from meshmark.cli.main import main as command

    with heard_by(report):
        code = command(job["command"])
    if code == 0 and job["registry"] and job["command"][0] == "embed":
        from meshmark.web.server.registered_name import register_name

        try:
            register_name(job["registry"], report.fields)
        except MeshmarkError as error:  # the copy is made and entered all the same
            report.remark(f"the registry keeps the temporary place of this copy: {error}")
    report.send(code=code, words=report.words, answer=report.fields)
    return 0


def _load() -> None:
    """Import what takes long, before there is a job."""
    import scipy.spatial

    import meshmark.authentication.verdict
    import meshmark.cli.authenticate
    import meshmark.cli.embed
    import meshmark.cli.extract
    import meshmark.cli.main
    import meshmark.marking.both_layers_extraction
    import meshmark.marking.marked_file  # noqa: F401

    del scipy


def _limit(job: Mapping[str, Any]) -> None:
    """Set the limits of the process: memory, no core files; a large job gives way to small ones."""
    most = int(job["memory"])
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if job["large"]:
        with contextlib.suppress(OSError):
            os.nice(5)


def _end_with_the_server() -> None:
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
