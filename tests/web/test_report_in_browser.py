"""The page of a report in a browser: nothing by network, a view that turns and changes its layers, accessible."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import meshmark as mm
from meshmark.report import picture, still_view
from meshmark.report.authentication_page import authentication_view, write_authentication_page
from meshmark.report.common_layers import own_surface
from meshmark.report.provenance import provenance
from meshmark.report.surface_view import surface_view
from meshmark.report.view_layer import heat_layer
from meshmark.report.view_surface import view_surface
from meshmark.web.viewer.parts import viewer_parts
from tests.counting import some
from tests.keys import KEY
from tests.marked import marked_pebble
from tests.textured import textured_glb

READY = "[data-state=ready]"


@pytest.fixture(scope="module")
def suspect() -> tuple[mm.Mesh, mm.Authentication]:
    """A marked pebble of which the right end was pushed, and what it tells."""
    marked = marked_pebble().mesh
    end = marked.vertices[:, 0] > np.quantile(marked.vertices[:, 0], 0.85)
    pushed = marked.with_vertices(np.where(end[:, None], 1.15 * marked.vertices, marked.vertices))
    return pushed, mm.authenticate(pushed, KEY)


@pytest.fixture(scope="module")
def report(suspect, tmp_path_factory, viewer_registered) -> Path:
    """The page of the suspect, its pictures as drafts."""
    folder = tmp_path_factory.mktemp("report")
    model, page = folder / "pebble.ply", folder / "report.html"
    mm.write_mesh(suspect[0], model)
    origin = provenance(
        model.name, {model.name: model}, KEY.fingerprint, made=datetime(2026, 11, 29, 8, 5, tzinfo=UTC)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(still_view, "SIZE", 200)
        patch.setattr(picture, "FINER", 1)
        write_authentication_page(*suspect, origin, page)
    return page


@dataclass
class Opened:
    """A page in a context of its own; trouble: requests that leave it, errors and warnings of its console."""

    page: Any
    trouble: list[str] = field(default_factory=list)

    def note(self, request: Any) -> None:
        if not request.url.startswith(("data:", "file:")):
            self.trouble.append(request.url)

    def picture(self) -> np.ndarray:
        """Return what the view shows, (height, width, 3)."""
        self.page.wait_for_timeout(60)
        shot = self.page.locator(".viewer-screen").screenshot()
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


@pytest.fixture(scope="module")
def opened(browser) -> Callable[..., Opened]:
    def open_(path: Path, *, state: str = READY) -> Opened:
        context = browser.new_context(viewport={"width": 1000, "height": 620}, reduced_motion="reduce")
        found = Opened(context.new_page())
        found.page.on("request", found.note)
        found.page.on("console", lambda line: line.type != "log" and found.trouble.append(line.text))
        found.page.on("pageerror", lambda error: found.trouble.append(str(error)))
        if state != READY:
            found.page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
        found.page.goto(path.as_uri())
        found.page.wait_for_selector(state)
        return found

    return open_


def red(picture: np.ndarray) -> int:
    """Return the number of pixels in the colour of failed checks."""
    return int(((picture[..., 0] > 90) & (picture[..., 0] > 1.6 * picture[..., 1])).sum())


def test_it_fits_asks_for_nothing_and_is_accessible(opened, report, axe):
    found = opened(report)
    for width, scheme in some(product((1280, 390), ("light", "dark"))):
        found.page.set_viewport_size({"width": width, "height": 800})
        found.page.emulate_media(color_scheme=scheme)
        found.page.wait_for_timeout(150)
        assert found.page.evaluate("document.documentElement.scrollWidth") <= width
        assert red(found.picture()) > 1000
        assert axe(found.page) == [], (width, scheme)
    found.page.emulate_media(media="print")
    assert not found.page.locator(".viewer").is_visible()
    assert found.page.locator(".pictures img").first.is_visible()
    assert found.trouble == []
    found.page.context.close()


def test_layers_keys_the_wheel_and_the_switch_of_light_change_what_is_seen(opened, report):
    found = opened(report)
    page, first = found.page, found.picture()
    page.check("input[value=surface]")
    page.wait_for_selector("[data-layer=surface]")
    assert red(found.picture()) == 0
    page.check("input[value=tamper]")
    page.wait_for_selector("[data-layer=tamper]")
    assert page.locator(".viewer-ticks").inner_text().split() == ["0", "50", "100"]
    assert np.abs(found.picture() - first).mean() < 0.5
    page.focus(".viewer-screen")
    for key in some(("ArrowRight", "+", "Shift+ArrowLeft")):
        before = found.picture()
        page.keyboard.press(key)
        assert np.abs(found.picture() - before).mean() > 0.5, key
    before = found.picture()
    page.mouse.move(300, 350)
    page.mouse.down()
    page.mouse.move(380, 320, steps=3)
    page.mouse.up()
    assert np.abs(found.picture() - before).mean() > 0.5
    page.click("button[aria-label='Reset the view']")
    page.evaluate("document.activeElement.blur()")
    assert np.abs(found.picture() - first).mean() < 0.5
    page.click("[data-theme-switch]")
    assert found.picture()[4, 4].sum() < 300 < first[4, 4].sum()
    page.click("[data-theme-switch]")
    page.set_viewport_size({"width": 1280, "height": 500})
    page.locator(".viewer-screen").hover()
    page.mouse.wheel(0, 100)
    page.wait_for_function("scrollY > 60")  # the page scrolls until the view is clicked
    page.locator(".viewer-screen").click()
    at = page.evaluate("scrollY")
    page.mouse.wheel(0, 100)
    page.wait_for_timeout(150)
    assert page.evaluate("scrollY") == at
    assert found.trouble == []
    page.context.close()


def test_without_webgl_the_page_says_so_and_has_its_pictures(opened, report):
    page = opened(report, state="[data-state=failed]").page
    assert "cannot be shown here" in page.locator(".stage").inner_text()
    assert page.locator(".pictures img").count() == 4
    page.context.close()


def test_a_viewer_of_another_page_is_made_and_disposed_of(browser, suspect):
    page = browser.new_page()
    made = """async ([source, view]) => {
      const { createViewer } = await import(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
      const element = document.body.appendChild(document.createElement("div"));
      const viewer = createViewer(element, view);
      await new Promise((done) => setTimeout(done, 300));
      const states = [element.dataset.state, viewer.layer];
      viewer.setLayer("surface");
      states.push(viewer.layer);
      viewer.dispose();
      let refused = "";
      const wrong = { ...view, vertices: view.vertices + 1 };
      try { createViewer(element, wrong); } catch (error) { refused = error.message; }
      return [...states, element.childElementCount, element.dataset.state ?? "none", refused];
    }"""
    view = json.loads(json.dumps(authentication_view(*suspect)))
    *states, refused = page.evaluate(made, [viewer_parts().script, view])
    assert states == ["ready", "tamper", "surface", 0, "none"]
    assert refused.startswith("positions take ")
    page.close()


def test_a_texture_is_worn_by_the_surface_and_taken_off_for_other_layers(browser, tmp_path):
    textured_glb(tmp_path / "four.glb")
    mesh = mm.read_mesh(tmp_path / "four.glb")
    height = heat_layer("height", "Height", mesh.vertices[:, 1], [(0.0, "0")])
    view = surface_view(view_surface(mesh), [own_surface(mesh), height], start="surface", label="a square")
    page = browser.new_page()
    made = """async ([source, view]) => {
      const { createViewer } = await import(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
      const element = document.body.appendChild(document.createElement("div"));
      window.viewer = createViewer(element, view);
      document.querySelector(".viewer-screen").style = "width: 300px; height: 300px";
      await new Promise((done) => setTimeout(done, 400));
    }"""
    page.evaluate(made, [viewer_parts().script, json.loads(json.dumps(view))])
    found = Opened(page)
    dressed = found.picture().reshape(-1, 3)
    shares = [
        np.mean((dressed[:, k] > 90) & (dressed[:, k] > 3 * np.delete(dressed, k, 1).max(axis=1)))
        for k in range(3)
    ]
    assert min(some(shares, least=3)) > 0.05, "red, green and blue are seen"
    page.evaluate("viewer.setLayer('height')")
    plain = found.picture().reshape(-1, 3)
    assert np.mean((plain[:, 2] > 90) & (plain[:, 2] > 3 * plain[:, :2].max(axis=1))) == 0
    page.evaluate("viewer.dispose()")
    page.close()
