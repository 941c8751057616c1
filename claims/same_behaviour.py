"""Record what the commands make and answer, and compare a later commit with it: for changes that must not change.

    python -m claims.same_behaviour record before.json     # on the commit before
    python -m claims.same_behaviour compare before.json    # on the commit after; exit 1 where anything differs

24 training models of all sizes, each in one of the seven formats or gzipped, with two keys: `embed`, `extract`,
`authenticate` (as marked and after a local edit), `recover` and `unmark`. SHA-256 of the files, JSON answers
without times and versions. Certificates hold undo data that is encrypted; the files that `unmark` makes of them are
compared.

Figures of docs/decisions/0018-layout.md.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import lzma
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from meshmark.io import read_mesh, write_mesh

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FORMATS = (".ply", ".obj", ".off", ".stl", ".glb", ".gltf", ".3mf", ".ply.gz")
KEYS = ("5a" * 32, "c3" * 32)
IDS = ("0123456789abcdef", "fedcba9876543210")
# Answers that differ from run to run, or were meant to change: `verified` was true of every answer, and is gone.
LEFT_OUT = ("seconds", "version", "verified")


def models() -> list[Path]:
    """Return 24 training models: every third by size up to 30,000 points, textured ones, and polygon soups."""
    classic = sorted((DATA / "models" / "train").glob("*"), key=lambda path: path.stat().st_size)
    coarse = sorted((DATA / "psb" / "train").glob("*"), key=lambda path: path.stat().st_size)
    textured = sorted((DATA / "textured").glob("*"))
    return [
        *classic[: 2 * len(classic) // 3 : 2][:12],
        *coarse[len(coarse) // 2 :: len(coarse) // 12][:6],
        *textured[::2][:6],
        *classic[20:24:2],
    ]


def prepared(path: Path, number: int, folder: Path) -> Path:
    """Return the model in the format that its number names; textured models stay as they are."""
    if path.suffix in {".glb", ".obj"}:
        return path
    plain = folder / path.name.removesuffix(".xz")
    plain.write_bytes(lzma.decompress(path.read_bytes()) if path.suffix == ".xz" else path.read_bytes())
    target = folder / f"input{FORMATS[number % len(FORMATS)]}"
    write_mesh(read_mesh(plain), target)
    return target


def run(*arguments: str | Path) -> dict[str, Any]:
    """Run a command with --json; return exit code, answer and errors."""
    command = [sys.executable, "-m", "meshmark", *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    answer = json.loads(done.stdout) if done.stdout.strip() else {}
    for name in LEFT_OUT:
        answer.pop(name, None)
    return {"exit": done.returncode, "answer": answer, "stderr": done.stderr}


def digest(path: Path) -> str | None:
    """Return the SHA-256 of a file, None where there is none."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else None


def behaviour(source: Path, number: int, key_number: int, folder: Path) -> dict[str, Any]:
    """Return what every command does with one model and one key."""
    model, key, suffix = prepared(source, number, folder), folder / "a.key", ""
    suffix = "".join(model.suffixes[-2:]) if model.suffix == ".gz" else model.suffix
    key.write_text(f"meshmark key 1\n{KEYS[key_number]}\n")
    key.chmod(0o600)
    marked, edited = folder / f"marked{suffix}", folder / f"edited{suffix}"
    whole, bare, certificate = folder / f"whole{suffix}", folder / f"bare{suffix}", folder / "a.cert"
    steps = {
        "embed": run(
            "embed", model, marked, "--key", key, "--id", IDS[key_number], "--certificate", certificate
        )
    }
    files = {"marked": marked}
    if marked.exists():
        steps["extract"] = run("extract", marked, "--key", key)
        steps["extract unmarked"] = run("extract", model, "--key", key)
        steps["authenticate"] = run("authenticate", marked, "--key", key)
        steps["attack"] = run("attack", marked, edited, "bump", "0.05")
        steps["authenticate edited"] = run("authenticate", edited, "--key", key)
        steps["recover"] = run("recover", edited, whole, "--key", key)
        steps["unmark"] = run("unmark", marked, bare, "--key", key, "--certificate", certificate)
        files |= {"edited": edited, "whole": whole, "bare": bare}
    text = json.dumps(steps).replace(str(folder), "").replace(str(DATA), "")
    return {"steps": json.loads(text), "files": {name: digest(path) for name, path in files.items()}}


def main() -> int:
    """Record or compare."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("task", choices=("record", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--limit", type=int, default=24)
    arguments = parser.parse_args()
    stored = json.loads(arguments.file.read_text()) if arguments.file.exists() else {}
    differing = 0
    for number, source in enumerate(models()[: arguments.limit]):
        for key_number in range(len(KEYS)):
            name = f"{source.relative_to(DATA)} key {key_number}"
            if (arguments.task == "record") == (name in stored):
                continue
            with tempfile.TemporaryDirectory() as folder:
                found = behaviour(source, number, key_number, Path(folder))
            if arguments.task == "record":
                stored[name] = found
                arguments.file.write_text(json.dumps(stored, indent=1))
                print(name, found["steps"]["embed"]["exit"], flush=True)
            else:
                lines = differences(_wanted(stored[name]), found)
                differing += bool(lines)
                print(name, "as before" if not lines else "DIFFERS", *lines, sep="\n    ", flush=True)
    return 1 if differing else 0


def _wanted(stored: Any) -> Any:
    """Return a record without the answers that are left out now."""
    if isinstance(stored, dict):
        return {name: _wanted(value) for name, value in stored.items() if name not in LEFT_OUT}
    return stored


def differences(before: Any, after: Any, place: str = "") -> list[str]:
    """Return a line for each place where two answers differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        names = sorted(before.keys() | after.keys())
        return [
            line
            for name in names
            for line in differences(before.get(name), after.get(name), f"{place}/{name}")
        ]
    return [] if before == after else [f"{place}: {str(before)[:80]} -> {str(after)[:80]}"]


if __name__ == "__main__":
    sys.exit(main())
