"""Compressed streams of a glTF are decoded in a process of its own, which may crash or hang without harm.

The process gets at most 1 GB of memory and 20 s for all streams of a file. What it returns is limited too, so that
reading the file takes no more than 1 GB and 30 s in all.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError

__all__ = ["Stream", "decode_streams"]

_CHILD = Path(__file__).with_name("codec_child.py")
_MEMORY, _SECONDS = 1 << 30, 20

# Meshopt says "these rows are equal" in next to nothing; meshes shrink to a tenth. A small file that claims to grow
# beyond both limits is a trap.
_MOST_GROWTH, _ALWAYS_ALLOWED = 100, 32 << 20

# What streams unpack to is held up to five times while a plain file is made of it.
_MOST_UNPACKED = 160 << 20


@dataclass(frozen=True, eq=False, kw_only=True)
class Stream:
    """One stream: where it stands in the file, its bytes, its codec with parameters, the size it unpacks to."""

    where: str
    data: bytes
    codec: str
    parameters: dict[str, Any]
    unpacked: int


def decode_streams(streams: Sequence[Stream]) -> list[dict[str, NDArray[Any]]]:
    """Return the arrays of each stream by name (see `codecs`).

    Raises `FormatError` where one cannot be decoded, or not within the limits.
    """
    given = sum(len(item.data) for item in streams)
    _check_size(sum(item.unpacked for item in streams), given)
    with tempfile.TemporaryFile() as sent, tempfile.TemporaryFile() as received:
        jobs = [{"codec": item.codec, "size": len(item.data), **item.parameters} for item in streams]
        sent.write(json.dumps(jobs).encode() + b"\n")
        sent.writelines(item.data for item in streams)
        sent.seek(0)
        code = _run(sent, received)
        _check_size(received.seek(0, os.SEEK_END), given)
        received.seek(0)
        return _answer(received, code, streams)


def _check_size(unpacked: int, given: int) -> None:
    if unpacked > max(_ALWAYS_ALLOWED, _MOST_GROWTH * given):
        raise FormatError(
            f"its compressed data of {given:,} bytes claims to unpack to {unpacked:,} bytes, which no mesh does"
        )
    if unpacked > _MOST_UNPACKED:
        raise FormatError(
            f"its compressed data unpacks to {unpacked >> 20} MB, the most that is read is "
            f"{_MOST_UNPACKED >> 20} MB: uncompress it with another tool first"
        )


def _run(sent: IO[bytes], received: IO[bytes]) -> int:
    # One thread: more reserve memory that the limit counts.
    settings = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(_CHILD), str(_MEMORY), str(_SECONDS)],
            stdin=sent,
            stdout=received,
            stderr=subprocess.DEVNULL,
            timeout=_SECONDS,
            env=settings,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise FormatError(f"its compressed data takes more than {_SECONDS} s to decode") from None
    return done.returncode


def _answer(received: IO[bytes], code: int, streams: Sequence[Stream]) -> list[dict[str, NDArray[Any]]]:
    try:
        head = json.loads(received.readline())
        if "error" in head:
            if head["error"] == "memory":
                raise FormatError(f"its compressed data needs more than {_MEMORY >> 30} GB to decode")
            raise FormatError(f"{streams[head['stream']].where}: {head['error']}")
        found: list[dict[str, NDArray[Any]]] = [{} for _ in streams]
        for number, name, dtype, shape in head["arrays"]:
            kind = np.dtype(dtype)
            rows = np.frombuffer(received.read(kind.itemsize * int(np.prod(shape))), kind)
            found[number][name] = rows.reshape(shape)
        return found
    except FormatError:
        raise
    except (ValueError, KeyError, IndexError, TypeError):
        reason = f"signal {-code}" if code < 0 else f"exit {code}"
        raise FormatError(f"its compressed data is damaged: the decoder ended by {reason}") from None
