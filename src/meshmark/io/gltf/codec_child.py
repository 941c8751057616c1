"""The process in which compressed glTF streams are decoded: streams on standard input, arrays on standard output.

A program of its own: the Draco library is native code, which a hostile stream may crash, and what a stream unpacks
to is not known before. `streams` starts it with limits on time and memory and speaks its protocol.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any


def _main() -> None:
    """Read, decode, write; a stream that cannot be decoded is an answer too."""
    memory, seconds = int(sys.argv[1]), int(sys.argv[2])
    _limit(memory, seconds)
    sys.path.insert(0, str(Path(__file__).parents[3]))
    from meshmark.io.gltf.codecs import decode

    # Libraries may print: nothing but the answer goes where the answer is read.
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    head = json.loads(sys.stdin.buffer.readline())
    described, pieces = [], []
    try:
        for number, job in enumerate(head):
            stream = sys.stdin.buffer.read(job.pop("size"))
            for name, array in decode(stream, **job).items():
                described.append([number, name, array.dtype.str, list(array.shape)])
                pieces.append(array)
    except MemoryError:
        _answer(answer, {"error": "memory"}, [])
    except ValueError as error:
        _answer(answer, {"error": " ".join(str(error).split())[:300], "stream": number}, [])
    else:
        _answer(answer, {"arrays": described}, pieces)


def _answer(stream: Any, head: dict[str, Any], pieces: list[Any]) -> None:
    stream.write(json.dumps(head).encode() + b"\n")
    for piece in pieces:
        stream.write(piece.tobytes())
    stream.flush()


def _limit(memory: int, seconds: int) -> None:
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (memory // 2, memory // 2))  # of the answer
        if sys.platform != "darwin":
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


if __name__ == "__main__":
    _main()
