"""The server's end of a process that runs one command."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

from meshmark.errors import MeshmarkError

__all__ = ["CommandProcess", "ProcessDied"]

_LINE_BYTES = 16 << 20
_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",  # each thread of a library reserves address space, which is limited
    "MKL_NUM_THREADS": "1",
}
_UNWANTED = ("MESHMARK_REGISTRY", "MESHMARK_TOKEN", "MESHMARK_DEBUG")


class ProcessDied(MeshmarkError):
    """A process that ended without an answer."""

    kind = "worker"


class CommandProcess:
    """A process that was started ahead, and runs one command; killed with all that it starts."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    @classmethod
    async def start(cls) -> CommandProcess:
        """Start one; it loads its libraries while nobody waits."""
        environment = {name: value for name, value in os.environ.items() if name not in _UNWANTED}
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "meshmark.web.server.command_child"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            env={**environment, **_ENVIRONMENT},
            limit=_LINE_BYTES,
            start_new_session=True,  # a group of its own, which can be killed as a whole
        )
        return cls(process)

    @property
    def is_alive(self) -> bool:
        """Return whether the process has not ended."""
        return self._process.returncode is None

    async def run(self, job: dict[str, Any], on_message: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
        """Run a job and return its last line; `on_message` gets those before. Raises `ProcessDied`."""
        stdin, stdout = self._process.stdin, self._process.stdout
        if stdin is None or stdout is None:
            raise ProcessDied("the process of this job has no pipes")
        with contextlib.suppress(ConnectionError):  # it has died: reading says so
            stdin.write(json.dumps(job).encode() + b"\n")
            await stdin.drain()
        while line := await stdout.readline():
            fields: dict[str, Any] = json.loads(line)
            if "code" in fields:
                await self.end()
                return fields
            on_message(fields)
        raise ProcessDied(_how_it_ended(await self._process.wait()))

    def kill(self) -> None:
        """Kill the process and all that it started."""
        if self.is_alive:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)

    async def end(self) -> None:
        """Kill the process and wait until it is gone."""
        self.kill()
        await self._process.wait()


def _how_it_ended(code: int) -> str:
    if code == -signal.SIGKILL:
        return "the process of this job was killed, probably because the computer ran out of memory"
    if code < 0:
        return f"the process of this job crashed ({signal.Signals(-code).name})"
    return f"the process of this job ended without an answer (exit code {code})"
