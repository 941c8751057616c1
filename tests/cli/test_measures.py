"""`compare`, `saliency`, `segment` and `info`: fields, exit codes, and what goes to which stream."""

from __future__ import annotations

import lzma
from pathlib import Path

import pytest
from json_object import only_object
from PIL import Image

from meshmark.io import write_mesh
from meshmark.mesh import Mesh
from tests.counting import some
from tests.shapes import pebble

COMPARE = {
    "rms_over_diagonal", "max_over_diagonal", "mrms_over_diagonal", "hausdorff_over_diagonal", "psnr_db",
    "paper_psnr_db", "msdm2", "normal_deviation_deg",
}  # fmt: skip


def test_compare_gives_the_fields_of_the_contract(cli, files, small_model):
    ran = cli("compare", files.model, files.marked, "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields.keys() >= COMPARE
    assert fields["rms_over_diagonal"] == pytest.approx(files.printed["rms_over_diagonal"], rel=1e-6)
    assert fields["psnr_db"] == pytest.approx(files.printed["psnr_db"], abs=1e-4)
    assert None not in [fields[name] for name in COMPARE]
    words = cli("compare", small_model, small_model).out
    assert {line.split("  ")[0] for line in words.splitlines()} == {
        "vertices, RMS", "vertices, largest", "surfaces, RMS", "surfaces, largest", "PSNR", "PSNR, paper",
        "MSDM2, 0 to 1", "normals, degrees",
    }  # fmt: skip


def test_compare_of_equal_models_is_json_without_infinity(cli, files):
    fields = only_object(cli("compare", files.model, files.model, "--json").out)
    assert (fields["rms_over_diagonal"], fields["max_over_diagonal"], fields["psnr_db"]) == (0.0, 0.0, None)
    assert "infinite" in cli("compare", files.model, files.model).out


def test_compare_of_other_vertex_counts_says_null(cli, tmp_path):
    model = tmp_path / "model.off"
    write_mesh(Mesh(*pebble(24)), model)
    (tmp_path / "t.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    ran = cli("compare", model, tmp_path / "t.off", "--json")
    assert ran.code == 0
    fields = only_object(ran.out)
    assert {name for name in COMPARE if fields[name] is None} == {"rms_over_diagonal", "max_over_diagonal"}
    assert "266" in cli("compare", model, tmp_path / "t.off").out


def test_saliency_gives_the_fields_of_the_contract_and_a_picture(cli, files, tmp_path):
    ran = cli("saliency", files.model, "--picture", tmp_path / "s.png", "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields["vertices"] == files.vertices
    assert fields["seconds"] > 0
    assert all(
        0 <= point["vertex"] < files.vertices and 0 <= point["beta"] <= 1
        for point in some(fields["salient_points"])
    )
    assert _is_drawn(tmp_path / "s.png")
    assert "salient points" in cli("saliency", files.model).out


def test_segment_gives_the_fields_of_the_contract_and_a_picture(cli, files, tmp_path):
    ran = cli("segment", files.model, "--picture", tmp_path / "s.png", "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert fields["balance"] >= 1
    for colour in ("green_share", "blue_share"):
        assert sum(region[colour] for region in fields["regions"]) == pytest.approx(1, abs=1e-6)
    assert all({"id", "salient_vertex"} <= region.keys() for region in some(fields["regions"]))
    assert _is_drawn(tmp_path / "s.png")
    assert "balance" in cli("segment", files.model).out


def test_info_counts(cli, files):
    ran = cli("info", files.model, "--json")
    fields = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    expected = {
        "format": "ply",
        "vertices": files.vertices,
        "points": files.vertices,
        "faces": files.faces,
        "parts": 1,
        "closed": True,
    }
    assert {name: fields[name] for name in expected} == expected
    assert f"{files.vertices:,}" in cli("info", files.model).out


@pytest.mark.shared
def test_info_is_json_for_textured_models(cli, shared_data):
    paths = [path for path in sorted((shared_data / "textured").iterdir()) if path.stat().st_size < 3e6]
    for path in some((path for path in paths if path.suffix in {".glb", ".obj"}), least=3):
        ran = cli("info", path, "--json")
        assert ran.code == 0, ran.err
        only_object(ran.out)


@pytest.mark.shared
def test_info_is_json_for_models_of_all_shapes(cli, shared_data, tmp_path):
    packed = sorted((shared_data / "models" / "test").glob("*.off.xz"))
    for path in some((path for path in packed if path.stat().st_size < 100_000), least=5):
        plain = tmp_path / path.stem
        plain.write_bytes(lzma.decompress(path.read_bytes()))
        ran = cli("info", plain, "--json")
        assert ran.code == 0, ran.err
        assert only_object(ran.out)["faces"] > 0


def _is_drawn(path: Path) -> bool:
    with Image.open(path) as image:
        return image.format == "PNG" and len(set(image.convert("L").resize((64, 64)).tobytes())) > 10
