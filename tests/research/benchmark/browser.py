"""Opens a page in headless Chromium and says what it found there."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
_FLAGS = [
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *(
        "--disable-background-networking",
        "--disable-component-update",
        "--enable-logging=stderr",
        "--dump-dom",
    ),
]
# A window cannot be narrower than 500 pixels, a frame can; what the frame saw is written on the page around it.
_FRAME = '<!DOCTYPE html><iframe style="border:0" width="{width}" height="900" srcdoc="{page}"></iframe>'
# Runs before anything else of the page; opens all that is folded, then notes what there is to see.
_WATCH = """<script>
const errors = [];
addEventListener("error", e => errors.push(String(e.message || e.target.outerHTML)), true);
addEventListener("unhandledrejection", e => errors.push(String(e.reason)));
addEventListener("load", () => {
  document.querySelectorAll("details").forEach(d => d.open = true);
  const sticksOut = e => !e.closest(".scroll table, svg") && e.getBoundingClientRect().right > innerWidth + 1;
  const widths = [...document.querySelectorAll("svg.panel")].map(e => e.getBoundingClientRect().width);
  parent.document.documentElement.setAttribute("data-seen", JSON.stringify({
    errors, width: innerWidth, scroll: document.documentElement.scrollWidth,
    out: [...document.querySelectorAll("main *, header *")].filter(sticksOut).map(e => e.outerHTML.slice(0, 120)),
    fetched: performance.getEntriesByType("resource").map(e => e.name),
    narrowest: Math.min(...widths, 9999), text: document.body.innerText.length}));
});
</script>"""


@dataclass(frozen=True)
class Seen:
    """What a page did: errors; the width it had and needs; what sticks out; what it fetched; its console."""

    errors: list[str]
    width: int
    scroll: int
    out: list[str]
    fetched: list[str]
    narrowest: float
    text: int
    console: str = ""


def look(page: str, folder: Path, width: int) -> Seen:
    """Open a page, with everything in it unfolded, in a frame of so many pixels."""
    watched = html.escape(page.replace("<head>", f"<head>{_WATCH}", 1))
    path = folder / f"watched-{width}.html"
    path.write_text(_FRAME.format(width=width, page=watched), encoding="utf-8")
    command = [CHROMIUM, *_FLAGS, f"--user-data-dir={folder / 'profile'}", "--window-size=1500,1000"]
    done = subprocess.run([*command, path.as_uri()], capture_output=True, text=True, timeout=120, check=True)
    (seen,) = re.findall(r'data-seen="([^"]*)"', done.stdout[:200_000])
    console = "\n".join(line for line in done.stderr.splitlines() if "CONSOLE" in line)
    return Seen(**json.loads(html.unescape(seen)), console=console)
