"""How large the page of a report is, how long it takes to make, and how soon it shows its view in Chromium.

    python -m claims.report_pages

The map is planted (the far end of the model, altered), as only the size of what is shown counts here; marking the
largest model would take an hour. The view is drawn by a processor, without graphics hardware: the slow case.
Bars: below 15 MB at 50,085 points; the first picture of 775,730 points in less than 3 s.

docs/report.md quotes its figures.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np

from claims.models import DATA, load
from meshmark.authentication.regions.region import Region
from meshmark.authentication.regions.region_map import RegionMap
from meshmark.authentication.verdict import Authentication
from meshmark.mesh import Mesh
from meshmark.report.authentication_page import write_authentication_page
from meshmark.report.provenance import provenance
from meshmark.segmentation import segment

MODELS = ("models/test/hand_50085.off.xz", "large/horse_loop2_775730.ply.xz")
LARGEST, LONGEST = 15e6, 3.0
TURNS = 5
FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def planted(mesh: Mesh) -> Authentication:
    """Return the result of an authentication in which the far end of the model is altered."""
    regions = segment(mesh).region
    along = (mesh.vertices[:, 0] - mesh.vertices[:, 0].min()) / np.ptp(mesh.vertices[:, 0])
    altered = along > 0.8
    checks = np.bincount(regions)
    failed = np.bincount(regions, altered).astype(int)
    rows = tuple(
        Region(
            id=i,
            verdict="altered" if failed[i] else "intact",
            probability=float(failed[i] > 0),
            checks=int(checks[i]),
            failed=int(failed[i]),
            log10_chance=0.0,
            centre=(0.0, 0.0, 0.0),
            where="somewhere",
        )
        for i in range(len(checks))
    )
    share = np.clip((along - 0.75) / 0.1, 0.0, 1.0)
    drawn = RegionMap(regions=rows, region=regions, failed_share=share, condition=altered.astype(np.int64))
    return Authentication(
        verdict="altered",
        altered=altered,
        altered_area_fraction=float(altered.mean()),
        missing_area_fraction=None,
        points_missing=None,
        payload="none",
        content=None,
        id=1,
        log10_false_positive=-40.0,
        mode="blind",
        certificate=None,
        advice="A planted map.",
        seconds=0.0,
        draw=lambda: drawn,
    )


def first_picture(browser: str, page: Path) -> float:
    """Return the median of the seconds from opening a page to the first picture of its view."""
    from playwright.sync_api import sync_playwright

    took = []
    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=browser, args=FLAGS)
        for _ in range(TURNS):
            tab = started.new_page(viewport={"width": 1280, "height": 900})
            began = time.perf_counter()
            tab.goto(page.as_uri())
            tab.wait_for_selector("[data-state=ready]")
            took.append(time.perf_counter() - began)
            tab.close()
        started.close()
    return median(took)


def main() -> int:
    """Print a line for each model; return 1 where a bar is missed."""
    browser = shutil.which("chromium") or sys.exit("there is no chromium, expected one to open the pages")
    missed = False
    with tempfile.TemporaryDirectory() as folder:
        for name in MODELS:
            mesh, page = load(DATA / name), Path(folder) / "report.html"
            found = planted(mesh)
            began = time.process_time()
            write_authentication_page(
                mesh, found, provenance(Path(name).name, {"model": DATA / name}, "0" * 16), page
            )
            made, size = time.process_time() - began, page.stat().st_size
            shown = first_picture(browser, page)
            print(
                f"{name}: {len(mesh.vertices):,} points; {size / 1e6:.1f} MB; made in {made:.1f} s of processor "
                f"time; first picture after {shown:.1f} s"
            )
            missed |= size > LARGEST or shown > LONGEST
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
