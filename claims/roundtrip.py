"""Load and save every model file at strength 0: the bytes must come back as they were.

Run: python -m claims.roundtrip [--data ../shared/data]
Each file is opened in a child process of its own with limits on time and memory: some of them are hostile.

Figures of docs/decisions/0016-odd-files.md.
"""

from __future__ import annotations

import argparse
import lzma
import multiprocessing
import resource
import sys
import tempfile
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

from meshmark.errors import MeshmarkError
from meshmark.io import FORMATS, read_mesh, write_mesh
from meshmark.io.formats import format_of_name

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
_SECONDS, _BYTES = 60, 4 << 30


def model_files(data: Path) -> list[Path]:
    """Return the files below `data` that are models by their name, compressed ones too."""
    return sorted(path for path in data.rglob("*") if path.is_file() and _plain_name(path) is not None)


def _plain_name(path: Path) -> str | None:
    name = path.name.removesuffix(".xz")
    return name if format_of_name(Path(name)) is not None else None


def check_file(path: Path) -> tuple[str, str, str]:
    """Return (format, outcome, detail); outcome: identical, refused, or FAILED."""
    name = _plain_name(path) or path.name
    with tempfile.TemporaryDirectory() as folder:
        source, out = path, Path(folder) / "out"
        out.mkdir()
        if path.suffix == ".xz":
            source = Path(folder) / name
            source.write_bytes(lzma.decompress(path.read_bytes()))
        try:
            mesh = read_mesh(source)
        except MeshmarkError as error:
            entry = format_of_name(source)
            return (entry.name if entry else "?"), "refused", str(error)
        kind = mesh.document.format if mesh.document is not None else "?"
        for written in write_mesh(mesh, out / name).files:
            if written.read_bytes() != (source.parent / written.relative_to(out.resolve())).read_bytes():
                return kind, "FAILED", f"{written.name} has other bytes"
        return kind, "identical", ""


def _child(path: Path, answer: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (_BYTES, _BYTES))
    try:
        answer.send(check_file(path))
    except BaseException as error:
        answer.send(("?", "FAILED", f"{type(error).__name__}: {error}"))


def guarded(path: Path) -> tuple[str, str, str]:
    """Return what `check_file` says, in a child process with limits on time and memory."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(path, sender))
    child.start()
    sender.close()
    try:
        if receiver.poll(_SECONDS):
            return receiver.recv()  # type: ignore[no-any-return]
        return "?", "FAILED", f"no answer within {_SECONDS} s"
    except EOFError:
        return "?", "FAILED", "the process died"
    finally:
        child.kill()
        child.join()


def main() -> int:
    """Print counts by format and every failure; return 1 if there is any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--refusals", action="store_true", help="print every refused file and why")
    options = parser.parse_args()
    counts: Counter[tuple[str, str]] = Counter()
    for path in model_files(options.data):
        kind, outcome, detail = guarded(path)
        counts[kind, outcome] += 1
        if outcome == "FAILED" or (options.refusals and outcome == "refused"):
            print(f"{outcome} {path.relative_to(options.data)}: {detail}")
    print(f"{'format':8}{'read':>8}{'identical':>11}{'refused':>9}{'failed':>8}")
    for kind in [*FORMATS, "?"]:
        same, bad, refused = (counts[kind, word] for word in ("identical", "FAILED", "refused"))
        if same + bad + refused:
            print(f"{kind:8}{same + bad:8}{same:11}{refused:9}{bad:8}")
    return int(any(outcome == "FAILED" for _, outcome in counts))


if __name__ == "__main__":
    sys.exit(main())
