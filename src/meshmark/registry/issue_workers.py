"""Processes that make copies: each is this program with a part of the recipients, and prints a line for each copy.

Keys are not handed from process to process; each reads the key file itself. A worker whose parent is gone ends with
the copy that it is at, as nobody reads its lines.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from meshmark.coding.message import parse_id
from meshmark.errors import CapacityError, InputError, MeshmarkError, OutputError, RegistryError
from meshmark.registry.issuing import Issued
from meshmark.registry.recipients import Recipient

__all__ = ["part_of", "run_part", "worked"]

_KINDS: dict[str, type[MeshmarkError]] = {
    kind.kind: kind for kind in (CapacityError, InputError, OutputError, RegistryError)
}


def worked(line: Sequence[str], workers: int, variables: Mapping[str, str]) -> Iterator[Issued]:
    """Run a command line in several processes, each with its part; yields the copies as they are made.

    variables: what the environment tells them besides: the place of the registry, which may hold a password.
    Raises the first error of a worker, after the others have ended the copies that they are at.
    """
    messages: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
    environment = {**os.environ, **variables}
    running = [
        subprocess.Popen(
            [sys.executable, "-m", "meshmark", *line, "--json", "--part", f"{number}/{workers}"],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
        )
        for number in range(workers)
    ]
    readers = [
        threading.Thread(target=_read, args=(process.stdout, messages), daemon=True) for process in running
    ]
    for reader in readers:
        reader.start()
    error: dict[str, Any] | None = None
    open_ones = workers
    try:
        while open_ones:
            values = messages.get()
            if values is None:
                open_ones -= 1
            elif "error" in values:
                error = error or values["error"]
            else:
                yield Issued(
                    recipient=values["recipient"],
                    id=parse_id(values["id"]),
                    path=Path(values["path"]),
                    made=values["made"],
                )
    finally:
        for process in running:
            if error is not None or open_ones:
                process.terminate()
            process.wait()
    codes = [process.returncode for process in running]
    if error is not None:
        raise _KINDS.get(error["kind"], InputError)(error["message"], file=error["file"])
    if any(codes):
        raise OutputError(
            f"a worker ended with exit code {max(codes, key=abs)}; --resume goes on where it was"
        )


def run_part(copies: Iterable[Issued]) -> int:
    """Make copies, and print a line for each."""
    for each in copies:
        print(json.dumps({**each.to_dict(), "made": each.made}), flush=True)
    return 0


def part_of(recipients: Sequence[Recipient], part: str) -> list[Recipient]:
    """Return the recipients of one of several processes: "0/2" are the first, the third, ..."""
    number, _, of = part.partition("/")
    return list(recipients[int(number) :: int(of)])


def _read(lines: IO[str] | None, messages: queue.SimpleQueue[dict[str, Any] | None]) -> None:
    try:
        for line in lines or ():
            messages.put(json.loads(line))
    finally:
        messages.put(None)
        if lines is not None:
            lines.close()
