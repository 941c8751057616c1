"""The documents and the program say the same."""

from __future__ import annotations

import importlib.util
import json
import re
import shlex
from importlib import resources
from pathlib import Path

import pytest

import meshmark as mm
from meshmark.cli.commands import COMMANDS
from meshmark.cli.extract import EXIT_CODES
from meshmark.io import FORMATS
from tests.counting import some

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


def test_the_command_line_page_is_what_the_program_prints():
    spec = importlib.util.spec_from_file_location("make_cli_docs", ROOT / "tools" / "make_cli_docs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (ROOT / "docs" / "cli.md").read_text(encoding="utf-8") == module.pages(), "run `make docs`"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_readme_names_every_command(name):
    assert f"`meshmark {name}" in README


def test_the_readme_names_every_format_and_what_a_conversion_keeps():
    rows = dict(re.findall(r"^\| \w+ \| `(\.\w+)` \| [^|]+ \| ([^|]+) \|$", README, re.MULTILINE))
    words = {"normals": "normals", "texcoords": "texture coordinates", "colors": "colours"}
    assert rows.keys() == {entry.extensions[0] for entry in FORMATS.values()}
    for entry in some(FORMATS.values()):
        kept = {name for name, word in words.items() if word in rows[entry.extensions[0]]}
        assert kept == entry.keeps, entry.name


def test_the_readme_names_every_strength_with_its_budget_and_psnr():
    from math import log10

    from meshmark.schemes.ncdg_lv.parameters import BUDGETS

    rows = re.findall(r"^\| `(\w+)` \| ([\d.]+) % \| ([\d.]+) dB \|", README, re.MULTILINE)
    assert {name: float(share) / 100 for name, share, _ in rows} == pytest.approx(BUDGETS)
    for name, _, psnr in some(rows):
        assert 0 <= -20 * log10(BUDGETS[name]) - float(psnr) < 0.1


def test_the_readme_names_every_exit_code():
    codes = {int(code) for code in re.findall(r"^\| (\d) \|", README, re.MULTILINE)}
    assert codes == {*EXIT_CODES.values(), 2}


@pytest.mark.parametrize("name", mm.__all__)
def test_the_readme_names_every_public_name(name):
    assert f"mm.{name}" in README


def test_the_python_example_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with resources.as_file(resources.files("meshmark") / "data" / "hare.ply.gz") as hare:
        mm.write_mesh(mm.read_mesh(hare), "hare.ply")
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    assert "present 0123456789abcdef" in capsys.readouterr().out


def test_the_tour_runs_and_prints_what_the_readme_shows(tmp_path, monkeypatch, capsys):
    from meshmark.cli.main import main

    monkeypatch.chdir(tmp_path)
    with resources.as_file(resources.files("meshmark") / "data" / "hare.ply.gz") as hare:
        mm.write_mesh(mm.read_mesh(hare), "hare.ply")
    tour = re.findall(r"```console\n(.*?)```", README, re.DOTALL)[0]
    for line, shown in some(re.findall(r"^\$ meshmark (.*)\n((?:(?!\$).*\n)*)", tour, re.MULTILINE)):
        assert main(shlex.split(line)) == ("extract hare" in line or "authenticate edited" in line)
        assert blurred(capsys.readouterr().out) == blurred(shown), line
        if "keygen" in line:  # which regions a part lies in depends on the key
            Path("my.key").unlink()
            mm.Key(bytes(32)).save("my.key")


def blurred(text: str) -> list[str]:
    """Return the lines of an output without the numbers that depend on the key drawn."""
    return re.sub(
        r"(?<![\w.])[\d,]+(\.\d+)?(?= ?%| dB|\.|$| marks| bytes| vertices moved| of \d+ reg| regions)|(?<=\^-)\d+",
        "#",
        text.strip(),
        flags=re.MULTILINE,
    ).splitlines()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in some(re.findall(r"\]\(([^)#:]+)\)", text)):
        assert (page.parent / target).exists(), target


def test_every_make_target_in_the_documents_exists():
    made = set(re.findall(r"^(\w+):.*##", (ROOT / "Makefile").read_text(), re.MULTILINE))
    said = set(re.findall(r"^make (\w+)", README + (ROOT / "CONTRIBUTING.md").read_text(), re.MULTILINE))
    assert said <= made


def test_the_changelog_tells_of_this_version():
    assert f"## {mm.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_the_constraints_are_names_and_versions_only():
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    assert lines
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][A-Za-z0-9.]*", line) for line in some(lines))


def test_the_model_that_comes_along_is_closed_and_well_shaped():
    import numpy as np

    from meshmark.metrics.shape import describe

    packed = resources.files("meshmark") / "data" / "hare.ply.gz"
    with resources.as_file(packed) as hare:
        assert hare.stat().st_size < 600_000
        mesh = mm.read_mesh(hare)
    shape = describe(mesh)
    assert shape.closed
    assert shape.parts == 1
    assert 20_000 <= shape.points <= 30_000
    corners = mesh.vertices[mesh.faces]
    edges = [np.linalg.norm(corners[:, i] - corners[:, i - 1], axis=1) for i in range(3)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert (area / np.max(edges, axis=0) ** 2).min() > 0.1, "no slivers"
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume > 0, "triangles face outwards"
    assert json.dumps(shape.to_dict())
