"""The page in a browser: a person marks, saves, checks, restores, finds the owner, and makes keys."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from meshmark.cli.main import main
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from tests.counting import some
from tests.glb_edits import Glb
from tests.shapes import pebble
from tests.web.server.served import Served

SLOW = 60_000
SKIN = b"\x89PNG\r\n\x1a\n" + bytes(range(256))


@dataclass
class Visit:
    """One person's page; trouble: what its console says, and requests that leave the server."""

    page: Any
    server: Served
    trouble: list[str] = field(default_factory=list)

    def begin(self, tab: str, *files: Path) -> None:
        self.page.click(f"#tab-{tab}")
        self.page.set_input_files(f"#{tab}-files", [str(path) for path in files])
        self.page.click(f"#{tab} form > .main")

    def verdict(self, tab: str) -> str:
        self.page.wait_for_selector(f"#{tab} .verdict h2", timeout=SLOW)
        return str(self.page.locator(f"#{tab} .verdict h2").last.inner_text())

    def save(self, label: str, folder: Path) -> Path:
        with self.page.expect_download() as waiting:
            self.page.get_by_role("link", name=label).click()
        path = folder / waiting.value.suggested_filename
        waiting.value.save_as(path)
        return path

    def alarms(self) -> int:
        """Return the number of pixels of the view in the colour of failed checks."""
        self.page.wait_for_selector("[data-state=ready].viewer", timeout=SLOW)
        self.page.wait_for_timeout(100)
        shot = self.page.locator(".viewer-screen").last.screenshot()
        picture = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)
        return int(((picture[..., 0] > 90) & (picture[..., 0] > 1.6 * picture[..., 1])).sum())


@pytest.fixture
def visit(browser) -> Callable[..., Visit]:
    """Open the page as another person each time."""
    opened = []

    def open_(server: Served, address: str = "/", **options: Any) -> Visit:
        settings = {"viewport": {"width": 1280, "height": 900}, "reduced_motion": "reduce", **options}
        context = browser.new_context(**settings)
        found, own = Visit(context.new_page(), server), (server.url, "blob:")
        opened.append(found)
        found.page.on("request", lambda each: each.url.startswith(own) or found.trouble.append(each.url))
        found.page.on(
            "console", lambda line: line.type in ("log", "verbose") or found.trouble.append(line.text)
        )
        found.page.on("pageerror", lambda error: found.trouble.append(str(error)))
        found.page.goto(f"{server.url}{address}")
        return found

    yield open_
    for each in opened:
        each.page.context.close()
    assert [each.trouble for each in opened if each.trouble] == []


def textured(path: Path) -> None:
    """Write a GLB whose surface wears a picture."""
    write_mesh(Mesh(*pebble(30)), path)
    glb = Glb.read(path.read_bytes())
    count = glb.tree["accessors"][glb.tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["count"]
    glb.put("images", bufferView=glb.view(SKIN), mimeType="image/png")
    glb.put("textures", source=0)
    material = glb.put("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    primitive = glb.tree["meshes"][0]["primitives"][0]
    primitive["material"] = material
    primitive["attributes"]["TEXCOORD_0"] = glb.array(np.random.default_rng(1).random((count, 2)))
    path.write_bytes(glb.bytes())


def test_a_textured_model_is_marked_saved_and_read_by_the_command_line(visit, server, tmp_path, capsys):
    textured(tmp_path / "ear.glb")
    one = visit(server)
    one.page.click("#mark summary")
    one.page.fill("#mark [name=id]", "00000000000000EA")
    one.begin("mark", tmp_path / "ear.glb")
    assert one.verdict("mark") == "The model is marked"
    marked = one.save("Save the marked model", tmp_path)
    certificate = one.save("Save the certificate", tmp_path)
    assert (marked.name, certificate.name) == ("ear_marked.glb", "ear_marked.cert")
    kept = Glb.read(marked.read_bytes())
    view = kept.tree["bufferViews"][kept.tree["images"][0]["bufferView"]]
    start = view.get("byteOffset", 0)
    assert bytes(kept.blob[start : start + view["byteLength"]]) == SKIN
    assert kept.tree["materials"] == Glb.read((tmp_path / "ear.glb").read_bytes()).tree["materials"]
    assert main(["authenticate", str(marked), "--key", str(server.key), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["id"] == "00000000000000ea"
    assert "00000000000000ea" in one.page.locator("#mark .verdict").inner_text()


def test_an_altered_copy_shows_its_map_and_what_was_altered_is_restored(visit, server, marked_file, tmp_path):
    mesh = read_mesh(marked_file)
    end = mesh.vertices[:, 0] > np.quantile(mesh.vertices[:, 0], 0.85)
    pushed = np.where(end[:, None], 1.15 * mesh.vertices, mesh.vertices)
    write_mesh(mesh.with_vertices(pushed), tmp_path / "cut.ply")
    one = visit(server)
    one.begin("check", tmp_path / "cut.ply")
    assert one.verdict("check") == "Altered since it was marked"
    assert one.alarms() > 500
    one.page.check("#check input[value=surface]")
    assert one.alarms() == 0
    one.page.get_by_role("button", name="Restore the altered part").click()
    one.page.wait_for_selector("text=The altered part is restored", timeout=SLOW)
    restored = read_mesh(one.save("Save the restored model", tmp_path))
    assert restored.vertices.shape == mesh.vertices.shape
    off = np.abs(restored.vertices - mesh.vertices)[end].max()
    assert off < np.abs(0.15 * mesh.vertices)[end].max() / 2


def test_a_broken_file_gives_the_sentence_and_the_page_goes_on(visit, server, marked_file, tmp_path):
    (tmp_path / "broken.ply").write_bytes(marked_file.read_bytes()[:2000])
    one = visit(server)
    one.begin("check", tmp_path / "broken.ply")
    assert one.verdict("check") == "This did not work"
    assert "broken.ply: line" in one.page.locator("#check .verdict p").inner_text()
    one.page.click("#check .remove")
    one.begin("check")
    assert one.page.locator("#check .wrong").inner_text() == "Choose a model first."


def test_two_people_mark_at_once_and_one_of_them_cancels(visit, server, pebble_file, marked_file):
    one, two = visit(server), visit(server)
    one.begin("mark", pebble_file)
    two.begin("owner", marked_file)
    one.page.get_by_role("button", name="Cancel").click()
    assert two.verdict("owner") == "Your mark is in this model"
    assert one.page.locator("#mark .outcome").inner_text() == ""
    assert one.page.locator("#mark form > .main").is_enabled()


def test_the_page_fits_and_is_accessible(visit, server, marked_file, axe):
    one = visit(server)
    one.begin("owner", marked_file)
    one.verdict("owner")
    one.page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    for width, scheme in some(product((1280, 390), ("light", "dark"))):
        one.page.set_viewport_size({"width": width, "height": 800})
        one.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        for tab in some(("mark", "owner") if width == 1280 else ("keys", "owner")):
            one.page.click(f"#tab-{tab}")
            assert one.page.evaluate("document.documentElement.scrollWidth") <= width, (tab, width)
            assert axe(one.page) == [], (tab, width, scheme)


def test_tabs_and_the_choice_of_light_work_by_keyboard(visit, server):
    page = visit(server).page
    page.wait_for_selector("body[data-state=ready]")
    page.focus("#tab-mark")
    page.keyboard.press("ArrowRight")
    assert page.locator("#check").is_visible()
    assert page.evaluate("document.activeElement.id") == "tab-check"
    page.keyboard.press("End")
    page.wait_for_url("**/#keys")
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.focus("#theme")
    page.keyboard.press("Enter")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before
    page.reload()
    page.wait_for_selector("body[data-state=ready]")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before
    assert page.locator("#keys").is_visible()


def test_whose_copy_a_suspect_is(visit, registry_server, axe, tmp_path):
    write_mesh(Mesh(*pebble(34)), tmp_path / "vase.ply")
    fields = {"recipient": "Eve", "id": "00000000000000a1", "layers": "ownership"}
    job = registry_server.run("embed", tmp_path / "vase.ply", **fields)
    marked = registry_server.save(job, "model", tmp_path)
    one = visit(registry_server, f"/#token={registry_server.token}")
    one.begin("owner", marked)
    assert one.verdict("owner") == "This is the copy of Eve"
    assert "00000000000000a1" in one.page.locator("#owner .table").inner_text()
    assert axe(one.page) == []
    one.page.locator("#owner .choice label").first.click()
    assert one.page.locator("#owner form > .main").inner_text() == "Look for the mark"
    assert one.page.locator("#owner [data-drop=original]").count() == 1
    one.trouble.clear()  # the page asked before it had its token


def test_with_a_token_and_a_registry_the_first_key_is_made_and_copies_are_listed(visit, registry_server):
    server, token = registry_server, registry_server.token
    one = visit(server)
    one.page.fill("#login input", "wrong")
    one.page.click("#login button")
    one.page.wait_for_selector("#login .wrong:visible")
    one.page.fill("#login input", token)
    one.page.keyboard.press("Enter")
    one.page.click("#tab-keys")
    one.page.fill("#keys [name=label]", "second")
    one.page.click("#keys form button")
    one.page.wait_for_selector("#key-table >> text=second")
    one.page.click("#tab-registry")
    one.page.wait_for_selector("#registry .said >> text=cop")
    one.trouble[:] = [each for each in one.trouble if "401" not in each]
    again = visit(server, f"/#token={token}")
    again.page.wait_for_selector("body[data-state=ready]")
    assert token not in again.page.url
    again.trouble.clear()
