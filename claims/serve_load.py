"""A model of 775,730 points through `meshmark serve`, and a second user's small one beside it again and again.

python -m claims.serve_load [--action embed] [--layers ownership] [--model PATH.xz] [--every 10] [--minutes 60]

One client uploads the large model; another one uploads a pebble of 2,382 points every few seconds and asks for the
id in it. Printed: how long the small jobs waited before they were begun, how long they took beside the same job on
the idle server, the slowest plain request, and the memory (resident, at its highest) of the server's own process,
of the process of the large job, and of all processes together.

Exit 1 where a small job waited, or a plain request took, more than 2 seconds, or all processes together exceeded
4 GB. For docs/serve.md.
"""

from __future__ import annotations

import argparse
import lzma
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2 as httpx

import meshmark as mm
from claims.models import DATA
from tests.shapes import pebble
from tests.web.server.served import OVER, Served, serving, wait_for

LARGE = "large/horse_loop2_775730.ply.xz"
MOST_WAIT, MOST_MEMORY = 2.0, 4e9


def processes(root: int) -> Iterator[int]:
    """Yield a process and all that descend from it."""
    yield root
    for task in Path(f"/proc/{root}/task").glob("*/children"):
        for child in task.read_text().split():
            yield from processes(int(child))


def resident(process: int) -> int:
    """Return the resident memory of a process in bytes, 0 where it has ended."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS")), 0)


class Watch(threading.Thread):
    """Looks at the memory of a server and its processes until it is stopped."""

    def __init__(self, root: int) -> None:
        super().__init__(daemon=True)
        self.root, self.stopped = root, threading.Event()
        self.server = self.one = self.all = 0

    def run(self) -> None:
        """Look twice a second."""
        while not self.stopped.wait(0.5):
            try:
                found = [resident(each) for each in processes(self.root)]
            except OSError:  # one ended meanwhile
                continue
            self.server, self.all = max(self.server, found[0]), max(self.all, sum(found))
            self.one = max(self.one, *found[1:], 0)


def small_job(server: Served, model: Path, client: httpx.Client) -> tuple[float, float, float]:
    """Run a small job; returns seconds until it was begun, until its end, and of the slowest request meanwhile."""
    start = time.perf_counter()
    job: dict[str, Any] = server.begin("extract", model, client=client).json()
    slowest, begun = time.perf_counter() - start, None
    while job["state"] not in OVER:
        if begun is None and job["state"] != "queued":
            begun = time.perf_counter() - start
        asked = time.perf_counter()
        job = client.get(f"/api/jobs/{job['id']}").json()
        slowest = max(slowest, time.perf_counter() - asked)
        time.sleep(0.02)
    end = time.perf_counter() - start
    if job["state"] != "done":
        raise SystemExit(f"the small job failed: {job['error']}")
    return begun or end, end, slowest


def main() -> int:
    """Measure; exit 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--action", default="embed", choices=("embed", "extract", "authenticate"))
    parser.add_argument("--layers", default="", choices=("", "both", "ownership", "authentication"))
    parser.add_argument("--model", default=LARGE)
    parser.add_argument("--every", type=float, default=10.0, metavar="SECONDS")
    parser.add_argument("--minutes", type=float, default=60.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        large = folder / Path(given.model).stem
        large.write_bytes(lzma.decompress((DATA / given.model).read_bytes()))
        small = folder / "pebble.ply"
        with serving(folder, "--job-time", str(int(60 * given.minutes))) as server, server.client() as client:
            client.post("/api/keys", json={"label": "studio"})
            marked = mm.embed(mm.Mesh(*pebble(70)), mm.Key.load(server.key), layers="ownership")
            mm.write_mesh(marked.mesh, small)
            order = {"action": given.action, **({"layers": given.layers} if given.layers else {})}
            return measured(server, client, large, small, every=given.every, order=order)


def measured(
    server: Served, client: httpx.Client, large: Path, small: Path, *, every: float, order: dict[str, str]
) -> int:
    """Run the large job and small ones beside it, and print what is seen."""
    alone = [small_job(server, small, client)[1] for _ in range(3)]
    watch = Watch(server.process.pid)
    watch.start()
    more = {name: value for name, value in order.items() if name != "action"}
    start, job = time.perf_counter(), server.begin(order["action"], large, client=client, **more).json()
    beside: list[tuple[float, float, float]] = []
    while client.get(f"/api/jobs/{job['id']}").json()["state"] not in OVER:
        beside.append(small_job(server, small, client))
        time.sleep(every)
    seconds = time.perf_counter() - start
    watch.stopped.set()
    found = wait_for(job["id"], client)
    waits, ends, requests = zip(*beside, strict=True)
    print(
        f"{' '.join(order.values())} of {large.name}: {found['state']} after {seconds:.0f} s {found['error'] or ''}"
    )
    print(
        f"{len(beside)} small jobs beside it: begun after {max(waits):.2f} s at most (bar: {MOST_WAIT:.0f})"
    )
    median = sorted(ends)[len(ends) // 2]
    print(f"they took {median:.2f} s at the median, {max(ends):.2f} at most; alone {min(alone):.2f}")
    print(f"slowest request {max(requests):.2f} s (bar: {MOST_WAIT:.0f})")
    gigabytes = [f"{value / 1e9:.2f} GB" for value in (watch.server, watch.one, watch.all)]
    print(f"memory: server {gigabytes[0]}, largest job {gigabytes[1]}, all together {gigabytes[2]} (bar: 4)")
    missed = max(waits) > MOST_WAIT or max(requests) > MOST_WAIT or watch.all > MOST_MEMORY
    return int(missed or found["state"] != "done")


if __name__ == "__main__":
    sys.exit(main())
