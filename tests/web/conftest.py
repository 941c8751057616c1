"""A headless Chromium for the tests of pages, one for each file of them, and axe-core within its pages."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

AXE = Path(__file__).resolve().parents[2] / "tools" / "node_modules" / "axe-core" / "axe.min.js"
FLAGS = (
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Return Debian's Chromium as Playwright drives it, with WebGL in software.

    For one module only: while it is there, a loop of asyncio runs, and no test can run one of its own.
    """
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    path = shutil.which("chromium")
    if path is None:
        pytest.skip("there is no Chromium")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=path, args=FLAGS)
        yield started
        started.close()


@pytest.fixture(scope="session")
def axe() -> Callable[[Any], list[str]]:
    """Return a function that lists the serious violations of accessibility rules on a page."""
    if not AXE.is_file():
        pytest.skip("axe-core is not installed (needs node; run `npm install --prefix tools`)")
    source = AXE.read_text(encoding="utf-8")

    def violations(page: Any) -> list[str]:
        page.evaluate(source)
        found = page.evaluate("axe.run()")
        assert len(found["passes"]) > 15
        return [
            f"{rule['id']}: {node['html'][:120]} {node['failureSummary']}"
            for rule in found["violations"]
            if rule["impact"] in ("serious", "critical")
            for node in rule["nodes"]
        ]

    return violations


@pytest.fixture(scope="session")
def viewer_registered() -> None:
    """Leave the test out where pages have no viewer because the wheel meshmark-web is not installed."""
    from meshmark.report.view_script import view_script

    if view_script() is None:
        pytest.skip("the wheel meshmark-web is not installed (`pip install -e ./web-wheel`)")
