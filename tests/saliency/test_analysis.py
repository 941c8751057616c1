from __future__ import annotations

import json

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.saliency import analyse
from tests.shapes import sphere_with_a_spike


def test_torn_apart_triangles_give_the_same_answer_in_file_vertices() -> None:
    points, faces, tip = sphere_with_a_spike()
    whole = analyse(Mesh(points, faces))
    torn = analyse(Mesh(points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)))
    assert whole.salient[0] == tip
    np.testing.assert_allclose(torn.beta, whole.beta[faces].ravel(), atol=1e-9)
    assert faces.ravel()[torn.salient].tolist() == whole.salient.tolist()


@pytest.mark.parametrize("power", [-300, 310])
def test_no_unit_changes_anything(power: int) -> None:
    points, faces, _ = sphere_with_a_spike()
    one, other = analyse(Mesh(points, faces)), analyse(Mesh(np.ldexp(points, power), faces))
    assert (one.beta == other.beta).all()
    assert (one.salient == other.salient).all()


def test_json_fields() -> None:
    points, faces, tip = sphere_with_a_spike()
    fields = json.loads(json.dumps(analyse(Mesh(points, faces)).to_dict()))
    assert fields["vertices"] == len(points)
    assert fields["salient_points"][0] == {"vertex": tip, "beta": 1.0}
    betas = [point["beta"] for point in fields["salient_points"]]
    assert betas == sorted(betas, reverse=True)
    assert fields["seconds"] >= 0.0


def test_a_model_without_a_surface_is_refused() -> None:
    with pytest.raises(InputError, match="1 faces, none with three different points"):
        analyse(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])))
