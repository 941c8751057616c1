"""Khronos' own validator finds nothing in our files that it did not find in the originals."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from meshmark.document import Attributes
from meshmark.io.gltf.convert import convert_glb, convert_gltf
from meshmark.io.gltf.parse import parse_glb, parse_gltf
from tests.counting import some
from tests.io.gltf_samples import CUBE, CUBE_FACES, SAMPLES, UNIT

TOOLS = Path(__file__).resolve().parents[2] / "tools"


def validate(paths: list[Path]) -> list[Counter[Any]]:
    """Return, per file, how often the validator says what about which part."""
    node = shutil.which("node")
    if node is None or not (TOOLS / "node_modules" / "gltf-validator").is_dir():
        pytest.skip("Khronos' validator is not installed (needs node; run `npm install --prefix tools`)")
    command = [node, str(TOOLS / "validate_gltf.mjs"), *map(str, paths)]
    lines = subprocess.run(
        command, capture_output=True, text=True, check=True, timeout=120
    ).stdout.splitlines()
    reports = [json.loads(line)["messages"] for line in lines]
    return [
        Counter((item["code"], item.get("pointer"), item["severity"]) for item in report)
        for report in reports
    ]


def test_patched_samples_are_as_valid_as_the_originals(tmp_path: Path) -> None:
    before, after = [], []
    for name, build in SAMPLES.items():
        for shell in ("glb", "gltf"):
            folder = tmp_path / f"{name} {shell}"
            folder.mkdir()
            before.append(folder / f"old.{shell}")
            after.append(folder / f"new.{shell}")
            data = build().glb() if shell == "glb" else build().external(folder)
            before[-1].write_bytes(data)
            document = (parse_glb if shell == "glb" else parse_gltf)(data, before[-1])
            vertices = (
                document.vertices + np.random.default_rng(5).normal(size=document.vertices.shape) * 1e-3
            )
            for other, content in document.patched(vertices, after[-1].name).items():
                (folder / other).write_bytes(content)
    reports = validate([*before, *after])
    assert len(reports) == 4 * len(SAMPLES)
    for path, old, new in some(zip(after, reports[: len(before)], reports[len(before) :], strict=True)):
        assert not new - old, path.name
        assert not [item for item in old if item[0] == "UNREADABLE"]


def test_fresh_files_are_valid_without_any_message(tmp_path: Path) -> None:
    colors = np.full((8, 4), 200, dtype=np.uint8)
    rich = Attributes(normals=UNIT, texcoords=CUBE[:, :2], colors=colors)
    paths = []
    for number, attributes in enumerate((Attributes(), rich, Attributes(colors=colors))):
        for convert, shell in ((convert_glb, "glb"), (convert_gltf, "gltf")):
            for shift in (0.0, 1e6):
                paths.append(tmp_path / f"{number}-{shift}.{shell}")
                files, _ = convert(CUBE + shift, CUBE_FACES, attributes, paths[-1].name)
                paths[-1].write_bytes(files[paths[-1].name])
    for path, report in some(zip(paths, validate(paths), strict=True)):
        # Texture coordinates without a material that has a texture are noted as unused: information only.
        assert not [item for item in report if item[0] != "UNUSED_OBJECT"], path.name


@pytest.mark.shared
def test_patched_textured_models_are_as_valid_as_the_originals(shared_data: Path, tmp_path: Path) -> None:
    originals = sorted((shared_data / "textured").glob("*.glb"))
    written = []
    for path in originals:
        document = parse_glb(path.read_bytes(), path)
        written.append(tmp_path / path.name)
        written[-1].write_bytes(document.patched(document.vertices * 1.001, path.name)[path.name])
    reports = validate([*originals, *written])
    for path, old, new in some(
        zip(originals, reports[: len(originals)], reports[len(originals) :], strict=True)
    ):
        assert not new - old, path.name
