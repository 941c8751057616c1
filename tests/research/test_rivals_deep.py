"""The deep rival: what the network is shown, its gradient, and the same numbers from numpy and from PyTorch."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from meshmark.attacks.chain import parse_chain
from meshmark.coding.keys import Key
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import Mesh
from meshmark.research.schemes.rivals.codeword import coded
from meshmark.research.schemes.rivals.deep3d.deep3d import Deep3d
from meshmark.research.schemes.rivals.deep3d.inputs import OUT, mean_of_neighbours, shown
from meshmark.research.schemes.rivals.deep3d.network import LENGTH, Network, Read, shipped_network
from meshmark.research.schemes.rivals.host import Host
from tests.counting import some
from tests.shapes import pebble

KEY = Key(b"d" * 32)
WITHOUT = "PyTorch is not installed: pip install 'meshmark-research[deep]'"
BITS = np.tile(np.array([0, 1], np.uint8), 32)


@pytest.fixture(scope="module")
def host():
    points, faces = pebble(60)
    return Host(Mesh(points * [0.6, 0.9, 1.5], faces))


@pytest.fixture(scope="module")
def seen(host):
    frame = canonical_frame(host.points, host.faces)
    return shown(frame.to_canonical(host.points), host.faces, mean_of_neighbours(host.graph))


@pytest.fixture(scope="module")
def message():
    return np.random.default_rng(1).choice([-1.0, 1.0], LENGTH).astype(np.float32)


def test_a_mean_of_neighbours_is_one(host):
    mean = mean_of_neighbours(host.graph)
    assert np.allclose(mean.sum(axis=1), 1.0)
    row = mean[[7]].toarray()[0]
    assert np.allclose(row @ host.points, host.points[host.edges[(host.edges == 7).any(axis=1)]].sum(axis=1).sum(
        axis=0) / (row > 0).sum() - host.points[7])  # fmt: skip


def test_what_sticks_out_is_seen_and_smooth_shapes_do_not(seen, host):
    moved = np.array(host.points)
    moved[500] += 0.02 * vertex_normals(host.points, host.faces)[500]
    frame = canonical_frame(host.points, host.faces)
    after = shown(frame.to_canonical(moved), host.faces, seen.mean)
    change = after.values[:, OUT] - seen.values[:, OUT]
    assert np.argmax(np.abs(change)) == 500
    assert change[500] > 0.5


def test_the_gradient_is_that_of_the_logits(seen):
    network, rng = shipped_network(), np.random.default_rng(2)
    toward, way = rng.normal(size=LENGTH).astype(np.float32), rng.normal(size=len(seen.values))
    expected = float(Read(network, seen).gradient(toward) @ way)

    def logits(step):
        values = seen.values.copy()
        values[:, OUT] += step * way
        return Read(network, replace(seen, values=values)).logits.astype(float)

    slope = float(toward @ (logits(1e-3) - logits(-1e-3))) / 2e-3
    assert np.isclose(slope, expected, rtol=0.02, atol=0.02 * np.linalg.norm(toward))


def test_moves_along_the_normals_have_the_adjoint_gradient(seen):
    rng = np.random.default_rng(3)
    by_out, heights = rng.normal(size=(2, len(seen.values)))
    places = heights[:, None] * seen.normals
    first = ((places - seen.mean @ places) * seen.normals).sum(axis=1)
    second = first - seen.mean @ first
    assert np.isclose(seen.by_heights(by_out) @ heights, by_out @ (seen.slope * second))


def test_refining_makes_the_weakest_bit_surer(host):
    marks = [Deep3d(refinements=number).marked(host.mesh, BITS, KEY, 2e-4) for number in (0, 6)]
    code = 1.0 - 2.0 * coded(BITS, KEY, 16)
    plain, refined = (Deep3d()._seen(Host(mesh), KEY, None)[0] * code for mesh in marks)
    assert refined.min() > max(plain.min(), 0.0)


@pytest.mark.parametrize("chain", ["similarity:1", "shuffle:1", "noise:0.0005", "float32:1"])
def test_the_mark_is_read_after(host, chain):
    marked = Deep3d().embed(host.mesh, BITS, KEY)
    found = Deep3d().extract(parse_chain(chain)(marked, np.random.default_rng(4)), KEY)
    assert found.present
    assert np.array_equal(found.bits, BITS)


def test_the_weights_are_small_plain_and_finite():
    file = resources.files("meshmark.research.schemes.rivals.deep3d").joinpath("weights.npz")
    with resources.as_file(file) as path:
        assert path.stat().st_size < 5_000_000
        with np.load(path, allow_pickle=False) as arrays:
            assert all(np.isfinite(arrays[name]).all() for name in some(arrays.files))


@pytest.fixture(scope="module")
def torch():
    return pytest.importorskip("torch", reason=WITHOUT)


@pytest.fixture(scope="module")
def pair(torch):
    """An embedder and an extractor whose batch norms have seen something."""
    from meshmark.research.schemes.rivals.deep3d.model import started

    torch.manual_seed(0)
    both = started(LENGTH)
    with torch.no_grad():
        for model in both:
            for name, value in [*model.named_parameters(), *model.named_buffers()]:
                if name.endswith(("norm.weight", "running_var", "gains")):
                    value.copy_(0.5 + torch.rand(value.shape))
                elif name.endswith(("norm.bias", "running_mean")):
                    value.copy_(0.1 * torch.randn(value.shape))
            model.eval()
    return both


def test_numpy_and_torch_agree(torch, pair, host, seen, message, tmp_path):
    from meshmark.research.schemes.rivals.deep3d.batches import Batch
    from meshmark.research.schemes.rivals.deep3d.export import save

    embedder, extractor = pair
    save(embedder, extractor, tmp_path / "weights.npz")
    with np.load(tmp_path / "weights.npz", allow_pickle=False) as arrays:
        network = Network({name: arrays[name].astype(np.float32) for name in arrays.files})
    batch = Batch([(canonical_frame(host.points, host.faces).to_canonical(host.points), host.faces)])
    with torch.no_grad():
        inputs = batch.inputs(batch.points)
        heights = embedder(inputs, torch.from_numpy(message)[None], batch)
        logits = extractor(inputs, batch)
    assert np.abs(inputs.numpy() - seen.values).max() < 0.02  # single precision of second differences
    assert np.corrcoef(heights.numpy(), network.heights(seen, message))[0, 1] > 0.999
    read = Read(network, replace(seen, values=inputs.numpy())).logits
    assert np.abs(read - logits.numpy()[0]).max() < 0.02 * np.abs(read).max()


def test_each_attack_layer_does_what_it_says(torch, host):
    from meshmark.research.schemes.rivals.deep3d.attack_layers import CROP, LAYERS, attacked
    from meshmark.research.schemes.rivals.deep3d.batches import Batch

    batch = Batch([(host.points, host.faces)])
    size, count = torch.tensor([0.01]), len(host.points)
    after = {layer: attacked(layer, batch, batch.points, size, np.random.default_rng(5)) for layer in LAYERS}
    assert after["none"][1] is batch.points
    moved = (after["noise"][1] - batch.points).numpy()
    assert 0.0 < moved.std() < 0.012
    arms = [points - points.mean(dim=0) for points in (batch.points, after["rotation"][1])]
    assert np.isclose(arms[0].norm(), arms[1].norm(), rtol=1e-3)
    rough = [(points - batch.mean(points)).norm() for points in (batch.points, after["smoothing"][1])]
    assert rough[1] < rough[0]
    cropped, points = after["crop"]
    assert (1.0 - CROP) * count - 1 <= len(points) < count
    assert cropped.faces.max() < len(points)


def test_training_writes_weights_and_a_curve(torch, host, tmp_path):
    from meshmark.research.schemes.rivals.deep3d.examples import example
    from meshmark.research.schemes.rivals.deep3d.training_loop import train

    rng = np.random.default_rng(6)
    models = [example(Mesh(*pebble(across)), rng) for across in (30, 34)]
    assert example(Mesh(*pebble(16)), rng) is None
    train(models, 2, 0, tmp_path / "weights.npz", tmp_path / "curve.csv")
    lines = (tmp_path / "curve.csv").read_text().splitlines()
    assert lines[0].startswith("step,seconds,message,curvature,errors,aside_none")
    assert lines[-1].startswith("2,")
    with np.load(tmp_path / "weights.npz", allow_pickle=False) as arrays:
        Network({name: arrays[name].astype(np.float32) for name in arrays.files})
