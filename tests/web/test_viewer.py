"""The bundle of the viewer is made of the sources beside it."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from meshmark.web.viewer.parts import FOLDER, viewer_parts
from tests.counting import some

ROOT = Path(__file__).resolve().parents[2]


def test_the_bundle_is_of_the_sources_and_the_pinned_packages():
    made_of = hashlib.sha256()
    for path in some(sorted((FOLDER / "source").iterdir()), least=5):
        made_of.update(path.read_bytes())
    packages = json.loads((ROOT / "tools" / "viewer" / "package.json").read_text())["devDependencies"]
    first = viewer_parts().script.splitlines()[0]
    expected = (
        f"/* meshmark viewer, sources {made_of.hexdigest()}, three {packages['three']},"
        f" esbuild {packages['esbuild']}."
    )
    assert first == expected, "node tools/viewer/build_viewer.mjs"


def test_the_bundle_can_stand_within_a_page_and_names_the_licence_of_three():
    parts = viewer_parts()
    assert "</script" not in parts.script
    assert (FOLDER / "THREE-LICENSE").read_text().strip() in parts.script
    assert "@import" not in parts.style
    assert "url(" not in parts.style
