"""Processor time of starting up, beside the interpreter and the libraries, and the size of what is installed.

python -m claims.start_up [--repeats 9]

Prints, for `import meshmark; meshmark.embed` (bar: 0.6 s) and `meshmark --help` (bar: 0.15 s), the least user and
system time of several fresh processes, byte code being there; beside it that of an empty program, `import numpy`,
`import scipy.sparse`, which embedding cannot do without, and of `import typer`, by which a slow or busy machine
shows.
Then the files of the core install: meshmark without extras and all that it needs, with and without byte code (bar:
250 MB without). Exit 1 where a bar is missed. For docs/decisions/0015-by-hand-or-library.md.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

PROGRAMS = {
    "python -c pass": (["-c", "pass"], None),
    "import numpy": (["-c", "import numpy"], None),
    "import scipy.sparse": (["-c", "import scipy.sparse"], None),
    "import typer": (["-c", "import typer"], None),
    "import meshmark; meshmark.embed": (["-c", "import meshmark; meshmark.embed"], 0.6),
    "meshmark --help": (["-m", "meshmark", "--help"], 0.15),
}
LARGEST = 250e6
ROOT = Path(__file__).parents[1]


def processor_time(command: list[str], environment: dict[str, str]) -> float:
    """Return the user and system seconds of one process."""
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawn(sys.executable, [sys.executable, *command], environment, file_actions=quiet)
    _, status, used = os.wait4(child, 0)
    if status:
        raise SystemExit(f"{' '.join(command)} failed")
    return used.ru_utime + used.ru_stime


def needed(requirement: str, found: set[str]) -> set[str]:
    """Add a distribution and all that it needs without extras to `found`, and return that."""
    name = re.split(r"[\s<>=!~;\[(]", requirement, maxsplit=1)[0]
    name = re.sub(r"[-_.]+", "-", name).lower()
    if name in found:
        return found
    try:
        requirements = distribution(name).requires or []
    except PackageNotFoundError:  # of another platform or Python
        return found
    found.add(name)
    for other in requirements:
        if "extra" not in other.partition(";")[2]:
            needed(other, found)
    return found


def sizes(names: set[str]) -> tuple[int, int]:
    """Return the bytes of the files of distributions, without and with the byte code of their modules."""
    plain = code = 0
    with tempfile.TemporaryDirectory() as cache:
        sources = []
        for name in sorted(names):
            files = [Path(str(file.locate())) for file in distribution(name).files or []]
            files = [path for path in files if path.suffix != ".pyc" and path.is_file()]
            plain += sum(path.stat().st_size for path in files)
            sources += [str(path) for path in files if path.suffix == ".py"]
        own = [path for path in (ROOT / "src" / "meshmark").rglob("*") if path.is_file()]
        own = [path for path in own if "research" not in path.parts and "__pycache__" not in path.parts]
        plain += sum(path.stat().st_size for path in own)
        sources += [str(path) for path in own if path.suffix == ".py"]
        listed = Path(cache) / "sources"
        listed.write_text("\n".join(sources))
        compiled = Path(cache) / "compiled"
        subprocess.run(
            [sys.executable, "-W", "ignore", "-m", "compileall", "-q", "-i", str(listed)],
            env={**os.environ, "PYTHONPYCACHEPREFIX": str(compiled)}, check=False, capture_output=True,
        )  # fmt: skip
        code = sum(path.stat().st_size for path in compiled.rglob("*.pyc"))
    return plain, plain + code


def main() -> int:
    """Measure and print; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=9)
    repeats = parser.parse_args().repeats
    missed = False
    with tempfile.TemporaryDirectory() as cache:
        kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        environment = {**kept, "PYTHONPYCACHEPREFIX": cache}
        print(f"{'program':34} {'seconds':>8} {'bar':>6}")
        for name, (command, bar) in PROGRAMS.items():
            processor_time(command, environment)  # makes the byte code
            least = min(processor_time(command, environment) for _ in range(repeats))
            missed |= bar is not None and least > bar
            print(f"{name:34} {least:8.3f} {'' if bar is None else bar:>6}", flush=True)
    names: set[str] = set()
    for requirement in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]:
        needed(requirement, names)
    plain, compiled = sizes(names)
    missed |= plain > LARGEST
    print(
        f"core install: {plain / 1e6:.0f} MB (bar {LARGEST / 1e6:.0f}), with byte code {compiled / 1e6:.0f} MB"
    )
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
