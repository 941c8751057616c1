"""Take the pictures of the page of `meshmark serve` that docs/serve.md shows: python tools/screenshot_serve.py.

Needs Chromium and Playwright. The hare is marked, its ears are stretched, and the copy is checked; a copy of Ann's
is traced. docs/images gets PNG files of at most 256 colours.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import meshmark as mm
from meshmark.data import hare_ply
from meshmark.registry.registry import Registry

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
COLOURS, SLOW = 256, 120_000
OTHERS = ((1280, "light"), (390, "dark"))
"""Widths and lights in which the tab Mark is kept."""
FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def edited_hare(folder: Path, key: Path) -> Path:
    """Write the hare, marked with a key, with its ears stretched; return the file."""
    (folder / "hare.ply").write_bytes(hare_ply())
    marked = mm.embed(mm.read_mesh(folder / "hare.ply"), mm.Key.load(key)).mesh
    points = marked.vertices.copy()
    ears = points[:, 1] > np.quantile(points[:, 1], 0.93)
    middle = points[ears].mean(axis=0)
    points[ears] = middle + 1.12 * (points[ears] - middle)
    mm.write_mesh(marked.with_vertices(points), folder / "suspect.ply")
    return folder / "suspect.ply"


def keep(page: Any, name: str, height: int) -> None:
    """Keep what is seen of a page, from its top to a height, as a PNG of few colours."""
    size = page.viewport_size
    page.set_viewport_size({"width": size["width"], "height": height})
    page.evaluate("document.activeElement.blur(); scrollTo(0, 0)")
    page.wait_for_timeout(700)
    with Image.open(io.BytesIO(page.screenshot())) as picture:
        picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / name, optimize=True)
    page.set_viewport_size(size)


def main() -> None:
    """Serve, visit, and take the pictures."""
    sys.path.insert(0, str(ROOT))
    from tests.web.server.served import serving

    browser = shutil.which("chromium") or sys.exit("there is no chromium, expected one to take the pictures")
    with tempfile.TemporaryDirectory() as name, sync_playwright() as driver, ExitStack() as stack:
        copies = Path(name) / "copies.db"
        Registry.create(copies)[0].database.close()
        server = stack.enter_context(serving(Path(name), "--registry", str(copies)))
        with server.client() as client:
            client.post("/api/keys", json={"label": "studio"})
        suspect = edited_hare(Path(name), server.key)
        started = driver.chromium.launch(executable_path=browser, args=FLAGS)
        for width, scheme in ((1280, "light"), (1280, "dark"), (390, "light"), (390, "dark")):
            page = started.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
            page.goto(server.url)
            page.wait_for_selector("body[data-state=ready]")
            if (width, scheme) in OTHERS:
                keep(page, f"serve-mark-{width}-{scheme}.png", 900)
            page.click("#tab-check")
            page.set_input_files("#check-files", str(suspect))
            page.click("#check form > .main")
            page.wait_for_selector(".viewer[data-state=ready]", timeout=SLOW)
            keep(page, f"serve-check-{width}-{scheme}.png", 1480 if width > 400 else 1700)
            page.close()
        page = started.new_page(viewport={"width": 1280, "height": 900}, color_scheme="light")
        issued = server.run("embed", Path(name) / "hare.ply", recipient="Ann")
        page.goto(f"{server.url}/#owner")
        page.wait_for_selector("body[data-state=ready]")
        page.set_input_files("#owner-files", str(server.save(issued, "model", Path(name))))
        page.click("#owner form > .main")
        page.wait_for_selector("#owner .viewer[data-state=ready]", timeout=SLOW)
        keep(page, "serve-trace-1280-light.png", 1480)
        started.close()


if __name__ == "__main__":
    main()
