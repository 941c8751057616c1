"""Take the pictures of a benchmark's page that the docs show: python tools/screenshot_report.py REPORT.html.

Needs Chromium. The pictures are the first part of the page at 1280 and at 400 pixels, as PNG of 64 colours.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
SIZES = {1280: 2300, 400: 2600}
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


def main(report: Path) -> None:
    """Write docs/images/bench-1280.png and bench-400.png."""
    browser = shutil.which("chromium") or sys.exit("there is no chromium, expected one to take the pictures")
    IMAGES.mkdir(parents=True, exist_ok=True)
    for width, height in SIZES.items():
        target = IMAGES / f"bench-{width}.png"
        with tempfile.TemporaryDirectory() as profile:
            where = (
                f"--user-data-dir={profile}",
                f"--window-size={width},{height}",
                f"--screenshot={target}",
            )
            subprocess.run(
                [browser, *FLAGS, *where, report.resolve().as_uri()], check=True, capture_output=True
            )
        with Image.open(target) as picture:
            picture.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
