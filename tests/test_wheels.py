"""The four wheels: what is in each, how they are joined, and that the product needs none of the others."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from meshmark.research.schemes.outside import ENTRY_POINTS as SCHEMES_GROUP
from tests.counting import some

ROOT = Path(__file__).resolve().parents[1]
LARGEST = 1_000_000


@pytest.fixture(scope="module")
def wheels(tmp_path_factory) -> dict[str, zipfile.ZipFile]:
    """The wheels, built from this checkout, by the name of the distribution."""
    out = tmp_path_factory.mktemp("wheels")
    for project in (ROOT, *sorted(ROOT.glob("*-wheel"))):
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", out],
            cwd=project, check=True, capture_output=True, timeout=120,
        )  # fmt: skip
    return {path.name.partition("-")[0]: zipfile.ZipFile(path) for path in sorted(out.glob("*.whl"))}


def text_of(wheel: zipfile.ZipFile, name: str) -> str:
    (found,) = [item for item in wheel.namelist() if item.endswith(f".dist-info/{name}")]
    return wheel.read(found).decode()


def test_the_wheel_of_the_product_is_small_and_without_the_others(wheels):
    wheel = wheels["meshmark"]
    names = some(wheel.namelist(), least=250)
    assert Path(wheel.filename).stat().st_size < LARGEST
    assert [name for name in names if "research" in name or name.endswith((".npz", ".npy"))] == []
    assert [name for name in names if name.startswith(("meshmark/web/", "meshmark/registry"))] == []
    assert {"meshmark/py.typed", "meshmark/data/hare.drc"} <= set(names)
    extras = {f"Provides-Extra: {name}" for name in ("registry", "research", "web")}
    assert extras <= set(text_of(wheel, "METADATA").splitlines())


def test_the_wheel_of_research_has_the_rest_and_needs_the_product_of_its_version(wheels):
    wheel = wheels["meshmark_research"]
    ours = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert all(name.startswith("meshmark/research/") for name in some(ours, least=90))
    assert "meshmark/research/schemes/rivals/deep3d/weights.npz" in ours
    assert ours & set(wheels["meshmark"].namelist()) == set(), "two wheels never write the same file"
    metadata = text_of(wheel, "METADATA")
    version = next(line.split()[1] for line in metadata.splitlines() if line.startswith("Version:"))
    assert f"Requires-Dist: meshmark[attacks]=={version}" in metadata


def test_the_wheel_of_the_registry_has_its_migrations_and_needs_the_product_of_its_version(wheels):
    wheel = wheels["meshmark_registry"]
    ours = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert {name.split("/")[1] for name in some(ours, least=20)} == {"registry", "registry_commands"}
    assert "meshmark/registry/migrations/versions/first_tables.py" in ours
    assert text_of(wheel, "entry_points.txt").splitlines() == [
        "[meshmark.commands]",
        "registry = meshmark.registry_commands.registry_group:registry",
        "trace = meshmark.registry_commands.trace:trace",
    ]
    metadata = text_of(wheel, "METADATA")
    version = next(line.split()[1] for line in metadata.splitlines() if line.startswith("Version:"))
    assert f"Requires-Dist: meshmark=={version}" in metadata
    assert "Requires-Dist: sqlalchemy" in metadata


def test_the_wheel_of_the_web_has_the_viewer_with_its_licences_and_needs_the_product_of_its_version(wheels):
    wheel = wheels["meshmark_web"]
    ours = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert all(name.startswith("meshmark/web/") for name in some(ours, least=5))
    viewer = {"viewer.bundle.js", "viewer.css", "THREE-LICENSE"}
    assert {"meshmark/web/LICENSE", *(f"meshmark/web/viewer/{name}" for name in viewer)} <= ours
    metadata = text_of(wheel, "METADATA")
    version = next(line.split()[1] for line in metadata.splitlines() if line.startswith("Version:"))
    assert f"Requires-Dist: meshmark=={version}" in metadata
    points = text_of(wheel, "entry_points.txt")
    assert "[meshmark.viewer]" in points
    assert "serve = meshmark.web.server.serve:serve" in points
    assert "Requires-Dist: fastapi" in metadata
    assert {f"meshmark/web/server/pages/{name}" for name in ("index.html", "page.css", "main.js")} <= ours


def test_the_wheels_together_have_every_source(wheels):
    sources = ROOT / "src"
    kept = {
        str(path.relative_to(sources))
        for path in (sources / "meshmark").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert kept <= {name for wheel in wheels.values() for name in wheel.namelist()}


def test_research_registers_its_commands(wheels):
    assert text_of(wheels["meshmark_research"], "entry_points.txt").split("\n\n")[0].splitlines() == [
        "[meshmark.commands]",
        "bench = meshmark.research.cli.bench:bench",
        "train = meshmark.research.cli.train:train",
    ]
    assert "meshmark.commands" not in text_of(wheels["meshmark"], "entry_points.txt")


def test_schemes_of_other_packages_are_found_under_the_published_name():
    assert SCHEMES_GROUP == "meshmark.schemes"
    assert '[project.entry-points."meshmark.schemes"]' in (ROOT / "docs" / "your-scheme.md").read_text()


def test_the_product_marks_reads_and_refuses_without_the_others(wheels, tmp_path):
    """The unpacked wheel, and nothing of this checkout, in a process in which the others cannot be imported."""
    wheels["meshmark"].extractall(tmp_path / "unpacked")
    code = f"""
import sys
from importlib.abc import MetaPathFinder

class TheProductAlone(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name.startswith(("meshmark.registry", "meshmark.research", "meshmark.web")):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, TheProductAlone())
import importlib.metadata
importlib.metadata.entry_points = lambda **_: ()
import meshmark as mm
sys.path.append({str(ROOT)!r})
from tests.shapes import pebble
assert mm.__file__.startswith({str(tmp_path)!r}), mm.__file__
key = mm.Key(bytes(range(32)))
marked = mm.embed(mm.Mesh(*pebble(72)), key, id=0xABCDEF, layers="ownership")
found = mm.extract(marked.mesh, key)
from meshmark.cli.main import main
print(found.presence, f"{{found.id:x}}", main(["bench", "smoke"]))
"""
    ran = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, timeout=240, check=False, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "unpacked")},
    )  # fmt: skip
    assert ran.stdout == "present abcdef 2\n", ran.stderr
    assert "pip install meshmark[research]" in ran.stderr
