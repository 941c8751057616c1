"""Requests and files that nobody means well, at `meshmark serve`: none is answered by a fault of the server.

python -m claims.serve_fuzz [--examples 300] [--files 200]

schemathesis makes requests of the server's own OpenAPI description, so many for each operation, half of them
against it. Then models of seven formats are damaged at random (bytes changed, cut, doubled) and uploaded, each with
an action drawn at random. Counted are the answers by status, and the outcomes of the jobs by kind of error.

Exit 1 where an answer is a 5xx, a job ends as a bug of the program, or the server does not answer in the end. For
docs/serve.md.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode

import meshmark as mm
from meshmark.io import FORMATS
from tests.shapes import pebble
from tests.web.server.served import Served, serving, wait_for

ACTIONS = ("embed", "extract", "authenticate", "recover")


def requests(server: Served, examples: int) -> Counter[int]:
    """Return how often each status was answered to requests made of the description."""
    schema = schemathesis.openapi.from_url(f"{server.url}/api/openapi.json")
    answered: Counter[int] = Counter()
    for result in schema.get_all_operations():
        operation: Any = result.ok()
        for mode in (GenerationMode.POSITIVE, GenerationMode.NEGATIVE):

            @settings(
                max_examples=max(examples // 2, 1),
                suppress_health_check=list(HealthCheck),
                database=None,
                deadline=None,
            )
            @given(case=operation.as_strategy(generation_mode=mode))
            def ask(case: Any) -> None:
                answer = case.call()
                answered[answer.status_code] += 1
                if answer.status_code >= 500:
                    print(case.as_curl_command(), answer.text[:300])

            with suppress(Unsatisfiable):  # nothing goes against an operation without parameters
                ask()
    return answered


def damaged(data: bytes, draw: random.Random) -> bytes:
    """Return a file with some bytes changed, cut out, or doubled."""
    found = bytearray(data)
    for _ in range(draw.choice((1, 1, 2, 8))):
        place, length = draw.randrange(len(found) + 1), draw.choice((1, 1, 4, 64, 2000))
        what = draw.randrange(3)
        if what == 0:
            found[place : place + length] = draw.randbytes(min(length, len(found) - place))
        elif what == 1:
            del found[place : place + length]
        else:
            found[place:place] = found[place : place + length]
    return bytes(found)


def files(server: Served, count: int, folder: Path) -> Counter[str]:
    """Return how often jobs with damaged files ended in each way."""
    draw, outcomes = random.Random(1), Counter[str]()
    mesh = mm.Mesh(*pebble(30))
    models = [folder / f"model{entry.extensions[0]}" for entry in FORMATS.values()]
    for path in models:
        mm.write_mesh(mesh, path)
    with server.client() as client:
        for _ in range(count):
            whole = draw.choice(models)
            path = folder / f"damaged{whole.suffix}"
            path.write_bytes(damaged(whole.read_bytes(), draw))
            answer = server.begin(draw.choice(ACTIONS), path, client=client)
            if answer.status_code != 202:
                outcomes[f"status {answer.status_code}"] += 1
                continue
            job = wait_for(answer.json()["id"], client)
            outcomes[job["error"]["kind"] if job["error"] else job["state"]] += 1
            if job["error"] and job["error"]["kind"] in ("bug", "worker"):
                kept = Path(tempfile.gettempdir()) / f"serve_fuzz_{outcomes.total()}{path.suffix}"
                kept.write_bytes(path.read_bytes())
                print(job["error"]["message"], "->", kept)
    return outcomes


def main() -> int:
    """Ask, upload, and count; exit 1 where the server is at fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--examples", type=int, default=300)
    parser.add_argument("--files", type=int, default=200)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "models").mkdir()
        with serving(Path(name)) as server:
            with server.client() as client:
                client.post("/api/keys", json={"label": "studio"})
            answered = requests(server, chosen.examples)
            outcomes = files(server, chosen.files, Path(name) / "models")
            with server.client() as client:
                alive = client.get("/api/server").status_code
    print(f"{answered.total()} requests, by status:", dict(sorted(answered.items())))
    print(f"{outcomes.total()} damaged files, by outcome:", dict(outcomes.most_common()))
    faults = sum(count for status, count in answered.items() if status >= 500)
    faults += outcomes["bug"] + sum(count for kind, count in outcomes.items() if kind.startswith("status 5"))
    print(f"faults of the server: {faults} (bar: 0); alive in the end: {'yes' if alive == 200 else 'no'}")
    return int(faults > 0 or alive != 200)


if __name__ == "__main__":
    sys.exit(main())
