"""Broken compressed files, and what reading each does to the process that reads it."""

from __future__ import annotations

import json
import multiprocessing
import resource
import struct
from collections import Counter
from collections.abc import Callable, Iterable
from multiprocessing.connection import Connection
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from claims.compressed_gltf.store import Broken, append, load
from meshmark.errors import InputError
from meshmark.io import read_mesh

__all__ = ["KINDS", "MEGABYTES", "SECONDS", "harmful", "measure_hostile", "summary"]

SECONDS, MEGABYTES = 30.0, 1024
_PATIENCE, _MEMORY = 120.0, 8 << 30  # a reader that exceeds them is ended
_COUNTS = ("count", "byteLength", "byteStride")
_CONTEXT = multiprocessing.get_context("forkserver")

Tree = dict[str, Any]
Random = np.random.Generator


def _flipped(tree: Tree, body: bytearray, rng: Random) -> None:
    """Flip up to 20 bits of the compressed streams."""
    for _ in range(int(rng.integers(1, 20))):
        start, size = _stream(tree, rng)
        body[start + int(rng.integers(0, size))] ^= 1 << int(rng.integers(0, 8))


def _header(tree: Tree, body: bytearray, rng: Random) -> None:
    """Put random bytes where a stream starts, which is where its own sizes and counts stand."""
    start, size = _stream(tree, rng)
    for place in rng.integers(0, min(size, 64), 4):
        body[start + int(place)] = int(rng.integers(0, 256))


def _cut(tree: Tree, body: bytearray, rng: Random) -> None:
    """Replace the end of a stream by zeros."""
    start, size = _stream(tree, rng)
    kept = int(rng.integers(0, size))
    body[start + kept : start + size] = bytes(size - kept)


def _swapped(tree: Tree, body: bytearray, rng: Random) -> None:
    """Put the bytes of one stream in the place of another."""
    (start, size), (other, there) = _stream(tree, rng), _stream(tree, rng)
    piece = body[other : other + min(size, there)]
    body[start : start + len(piece)] = piece


def _miscounted(tree: Tree, _body: bytearray, rng: Random) -> None:
    """Multiply counts, sizes and strides of the JSON."""
    records = [entry for entry in _records(tree) if "count" in entry or "byteLength" in entry]
    for entry in rng.choice(np.array(records, dtype=object), 3):
        for key in _COUNTS:
            if key in entry:
                entry[key] = int(entry[key] * rng.choice([0.5, 2, 10, 1000, 1e6]))


# What is done to the JSON and the bytes of a sound file, in place.
KINDS: dict[str, Callable[[Tree, bytearray, Random], None]] = {
    "flipped": _flipped,
    "header": _header,
    "cut": _cut,
    "swapped": _swapped,
    "miscounted": _miscounted,
}


def _stream(tree: Tree, rng: Random) -> tuple[int, int]:
    """Return start and size of a compressed stream drawn at random."""
    views = tree["bufferViews"]
    draco = [
        views[item["extensions"]["KHR_draco_mesh_compression"]["bufferView"]]
        for mesh in tree["meshes"]
        for item in mesh["primitives"]
        if "KHR_draco_mesh_compression" in item.get("extensions", {})
    ]
    meshopt = [
        record
        for view in views
        for name, record in view.get("extensions", {}).items()
        if name.endswith("meshopt_compression")
    ]
    found = draco + meshopt
    chosen = found[int(rng.integers(0, len(found)))]
    return chosen.get("byteOffset", 0), chosen["byteLength"]


def _records(part: Any) -> list[Tree]:
    if isinstance(part, list):
        return [entry for item in part for entry in _records(item)]
    if not isinstance(part, dict):
        return []
    return [part, *(entry for item in part.values() for entry in _records(item))]


def broken(data: bytes, kind: str, seed: tuple[int, ...]) -> bytes:
    """Return a broken copy of a compressed GLB."""
    size = struct.unpack_from("<I", data, 12)[0]
    tree, body = json.loads(data[20 : 20 + size]), bytearray(data[28 + size :])
    KINDS[kind](tree, body, np.random.default_rng(seed))
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(body), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(body), b"BIN\0") + bytes(body)


def _read(path: str, answer: Connection) -> None:
    """Read one file in a fresh process; send how it went, the peak memory of both processes, and the seconds."""
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    start, message = perf_counter(), ""
    try:
        read_mesh(path)
        outcome = "read"
    except InputError as error:
        message = str(error)
        outcome = "refused" if message and "\n" not in message else "no sentence"
    except BaseException as error:
        outcome, message = "crash", f"{type(error).__name__}: {error}"
    seconds = perf_counter() - start
    peaks = [
        resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    ]
    answer.send((outcome, *peaks, seconds, message))


def probe(path: Path) -> tuple[str, int, int, float, str]:
    """Read a file in a process of its own: how it went, MB of reader and of decoder, seconds, the sentence."""
    ours, theirs = _CONTEXT.Pipe(duplex=False)
    process = _CONTEXT.Process(target=_read, args=(str(path), theirs))
    process.start()
    theirs.close()
    try:
        if ours.poll(_PATIENCE):
            outcome, own, child, seconds, message = ours.recv()
            return outcome, own, child, seconds, message
        return "hang", 0, 0, _PATIENCE, ""
    except EOFError:
        process.join()
        return f"crash, exit code {process.exitcode}", 0, 0, 0.0, ""
    finally:
        process.kill()
        process.join()


def measure_hostile(files: Iterable[Path], count: int, store: Path) -> list[Broken]:
    """Read `count` broken files of each kind made from each file; what the store has is not repeated."""
    _CONTEXT.set_forkserver_preload(["claims.compressed_gltf.hostile", "meshmark.io.gltf.parse"])
    path = store / "hostile.jsonl"
    done = {(row.file, row.kind, row.number): row for row in load(path, Broken)}
    rows = []
    for file in files:
        digest = int(file.name[:8], 16)
        for place, kind in enumerate(KINDS):
            for number in range(count):
                key = (file.name, kind, number)
                if key not in done:
                    made = store / "broken.glb"
                    made.write_bytes(broken(file.read_bytes(), kind, (digest, place, number)))
                    outcome, own, child, seconds, message = probe(made)
                    done[key] = Broken(
                        file=file.name,
                        kind=kind,
                        number=number,
                        outcome=outcome,
                        own=own,
                        child=child,
                        seconds=round(seconds, 2),
                        message=message[:300],
                    )
                    append(path, done[key])
                    if harmful(done[key]):
                        print(done[key], flush=True)
                rows.append(done[key])
    return rows


def harmful(row: Broken) -> bool:
    """Return whether a broken file did more than be read or refused, within the limits of memory and time."""
    sound = row.outcome in ("read", "refused")
    return not (sound and max(row.own, row.child) < MEGABYTES and row.seconds < SECONDS)


def summary(rows: list[Broken]) -> str:
    """Return a line per kind: how many were read, refused or worse, and the most memory and time."""
    lines = [
        f"{'broken streams':16} {'read':>6} {'refused':>8} {'harmful':>8}  most MB (reader, decoder), most s"
    ]
    for kind in (*KINDS, "all"):
        own = [row for row in rows if kind in ("all", row.kind)]
        seen = Counter("harmful" if harmful(row) else row.outcome for row in own)
        most = [max((getattr(row, name) for row in own), default=0) for name in ("own", "child", "seconds")]
        counts = f"{seen['read']:6} {seen['refused']:8} {seen['harmful']:8}"
        lines.append(f"{kind:16} {counts}  {most[0]}, {most[1]}, {most[2]}")
    return "\n".join(lines)
