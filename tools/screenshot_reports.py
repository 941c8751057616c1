"""Take the pictures of docs/report.md: python tools/screenshot_reports.py AUTHENTICATION.html RECOVERY.html.

Needs Chromium and Playwright. Of the first page: light at 1280 pixels with the tamper map, dark at 1280 with the
regions, light at 390 with the altered parts; of the second: dark at 390. PNG of 256 colours.
"""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
HEIGHTS = {1280: 900, 390: 844}


def main(authentication: Path, recovery: Path) -> None:
    """Write docs/images/report-*.png."""
    browser = shutil.which("chromium") or sys.exit("there is no chromium, expected one to take the pictures")
    shots = (
        ("report-1280-light", authentication, 1280, "tamper"),
        ("report-1280-dark", authentication, 1280, "regions"),
        ("report-390-light", authentication, 390, "parts"),
        ("report-390-dark", recovery, 390, "restored"),
    )
    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=browser, args=FLAGS)
        for name, page, width, layer in shots:
            tab = started.new_page(
                viewport={"width": width, "height": HEIGHTS[width]}, color_scheme=name.rpartition("-")[2]
            )
            tab.goto(page.resolve().as_uri())
            tab.wait_for_selector("[data-state=ready]")
            tab.check(f"input[value={layer}]")
            tab.wait_for_selector(f"[data-layer={layer}]")
            tab.wait_for_timeout(300)
            picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
            picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(
                IMAGES / f"{name}.png", optimize=True
            )
            tab.close()
        started.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
