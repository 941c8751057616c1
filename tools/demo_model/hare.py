"""The hare: where its parts are, which way its fur lies, and how it is coloured."""

from __future__ import annotations

import numpy as np

from demo_model.noise import brushed, noise
from demo_model.solids import Array, carve, ellipsoid, join, leaf, limb, turn

LOW, HIGH = np.array([-1.35, -0.3, -1.6]), np.array([1.4, 3.35, 1.4])


def at(*xyz: float) -> Array:
    """Return a point."""
    return np.array(xyz)


# The head is turned a little to its left and tilted: a frame that no mirror image shares.
HEAD = at(0.03, 1.74, 0.42)
HEAD_TURN = turn(x=8.0, y=-16.0, z=5.0)
EAR_KNOTS = 13


def _on_head(*xyz: float) -> Array:
    return HEAD + HEAD_TURN @ at(*xyz)


def body(p: Array) -> Array:
    """Return the distance to trunk, legs and tail."""
    d = ellipsoid(p, at(0, 0.66, -0.36), at(0.60, 0.60, 0.70), turn(x=-18))
    d = join(d, ellipsoid(p, at(0, 0.98, 0.12), at(0.46, 0.62, 0.46), turn(x=14)), 0.35)
    d = join(d, ellipsoid(p, at(0, 0.92, 0.42), at(0.30, 0.42, 0.24), turn(x=10)), 0.22)
    d = join(d, limb(p, at(0, 1.25, 0.20), HEAD + at(0, -0.12, -0.08), 0.33, 0.25), 0.30)
    for side in (-1.0, 1.0):
        thigh = ellipsoid(p, at(0.43 * side, 0.48, -0.26), at(0.24, 0.42, 0.50), turn(x=-24, z=-8 * side))
        d = join(d, thigh, 0.13)
        d = join(d, limb(p, at(0.50 * side, 0.10, -0.22), at(0.54 * side, 0.09, 0.44), 0.15, 0.125), 0.14)
        d = join(d, limb(p, at(0.23 * side, 0.92, 0.34), at(0.19 * side, 0.14, 0.60), 0.19, 0.105), 0.12)
        d = join(d, ellipsoid(p, at(0.19 * side, 0.09, 0.68), at(0.125, 0.10, 0.19)), 0.07)
        for toe in (-1.0, 1.0):
            d = carve(
                d,
                limb(
                    p,
                    at(0.19 * side + 0.05 * toe, 0.14, 0.80),
                    at(0.19 * side + 0.05 * toe, 0.02, 0.92),
                    0.001,
                    0.004,
                ),
                0.10,
            )
            d = carve(
                d,
                limb(
                    p,
                    at(0.54 * side + 0.05 * toe, 0.16, 0.48),
                    at(0.54 * side + 0.05 * toe, 0.02, 0.62),
                    0.001,
                    0.004,
                ),
                0.10,
            )
    return join(d, ellipsoid(p, at(0.02, 0.46, -1.12), at(0.21, 0.23, 0.21)), 0.10)


def head(p: Array) -> Array:
    """Return the distance to the head without the ears."""
    q = (p - HEAD) @ HEAD_TURN
    d = ellipsoid(q, at(0, 0.02, 0.04), at(0.335, 0.335, 0.43), turn(x=14))
    d = join(d, ellipsoid(q, at(0, -0.10, 0.38), at(0.19, 0.165, 0.22), turn(x=10)), 0.16)
    for side in (-1.0, 1.0):
        d = join(d, ellipsoid(q, at(0.16 * side, -0.13, 0.22), at(0.19, 0.19, 0.22)), 0.12)
        d = join(d, ellipsoid(q, at(0.075 * side, -0.115, 0.52), at(0.095, 0.085, 0.10)), 0.05)
        d = carve(
            d, ellipsoid(q, at(0.315 * side, 0.075, 0.235), at(0.07, 0.10, 0.115), turn(y=20 * side)), 0.08
        )
    d = carve(d, limb(q, at(0, -0.10, 0.66), at(0, -0.20, 0.60), 0.008, 0.02), 0.05)
    return join(d, ellipsoid(q, at(0, -0.045, 0.60), at(0.075, 0.05, 0.05)), 0.03)


def eyes(p: Array) -> Array:
    """Return the distance to the eyes."""
    q = (p - HEAD) @ HEAD_TURN
    return np.minimum(
        *(np.linalg.norm(q - at(0.262 * side, 0.065, 0.225), axis=-1) - 0.098 for side in (-1.0, 1.0))
    )


def _ear_curve(points: list[Array]) -> Array:
    t = np.linspace(0.0, 1.0, EAR_KNOTS)[:, None]
    a, b, c, d = points
    return (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d


# One ear upright, the other with its tip folded over.
EARS = (
    (
        _ear_curve(
            [
                _on_head(0.19, 0.20, -0.07),
                _on_head(0.22, 0.62, -0.16),
                _on_head(0.36, 1.00, -0.26),
                _on_head(0.30, 1.38, -0.30),
            ]
        ),
        at(-0.05, 0.05, 1.0),
    ),
    (
        _ear_curve(
            [
                _on_head(-0.19, 0.20, -0.07),
                _on_head(-0.20, 0.70, -0.22),
                _on_head(-0.38, 1.28, -0.24),
                _on_head(-0.78, 0.98, 0.06),
            ]
        ),
        at(0.05, 0.05, 1.0),
    ),
)
_T = np.linspace(0.0, 1.0, EAR_KNOTS)
EAR_WIDTH = 0.10 + 0.115 * np.sin(np.pi * np.clip(0.06 + 0.90 * _T, 0, 1)) ** 0.9 - 0.05 * _T
EAR_THICK = 0.095 - 0.022 * _T


def ears(p: Array) -> Array:
    """Return the distance to both ears."""
    leaves = []
    for curve, out in EARS:
        facing = np.repeat((HEAD_TURN @ out)[None], EAR_KNOTS, axis=0)
        leaves.append(leaf(p, curve, facing, EAR_WIDTH, EAR_THICK, 0.38))
    return join(*leaves, 0.06)


def ground(p: Array) -> Array:
    """Return the distance to the mound the hare sits on."""
    bumps = 0.05 * noise(p * 1.7, 5) + 0.02 * noise(p * 4.6, 6)
    d = ellipsoid(p, at(0.02, -0.10, -0.12), at(1.22, 0.20, 1.36)) - bumps
    return -join(-d, p[..., 1] + 0.22, 0.06)


def hare(p: Array) -> Array:
    """Return the distance to the whole figure."""
    d = join(body(p), head(p), 0.14)
    d = join(d, ears(p), 0.07)
    d = join(d, eyes(p), 0.05)
    return join(d, ground(p), 0.05)


def flow(p: Array) -> Array:
    """Return which way the fur lies: from the nose back over the head, down the body, out along the ears."""
    to_nose = p - _on_head(0, -0.05, 0.75)
    over_head = to_nose / np.linalg.norm(to_nose, axis=1, keepdims=True)
    down = np.broadcast_to(at(0.0, -0.85, -0.5), p.shape)
    up = np.broadcast_to(at(0.0, 1.0, -0.2), p.shape)
    near_head = np.clip(1.3 - 2.2 * np.maximum(head(p), 0.0), 0.0, 1.0)[:, None]
    near_ear = np.clip(1.5 - 12.0 * np.maximum(ears(p), 0.0), 0.0, 1.0)[:, None]
    out = (1 - near_ear) * (near_head * over_head + (1 - near_head) * down) + near_ear * up
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)


def relief(p: Array) -> Array:
    """Return the height of fur and moss above the plain solid, (n,)."""
    fur = 0.008 * brushed(p, flow, 0.34, 0.058, 11) + 0.006 * noise(p * 5.0, 12)
    moss = 0.013 * noise(p * 9.0, 13) + 0.010 * noise(p * 15.0, 14)
    bare = np.clip(25.0 * eyes(p), 0.0, 1.0)
    q = (p - HEAD) @ HEAD_TURN
    bare *= np.clip(12.0 * (np.linalg.norm(q - at(0, -0.05, 0.62), axis=1) - 0.06), 0.1, 1.0)
    bare *= 1.0 - 0.65 * np.clip(1.5 - 20.0 * np.maximum(ears(p), 0.0), 0.0, 1.0)
    on_ground = _step(ground(p), 0.03, 0.0) * _step(furred(p), 0.0, 0.03)
    return (1 - on_ground) * bare * fur + on_ground * moss


def furred(p: Array) -> Array:
    """Return the distance to the hare without its mound."""
    return join(join(join(body(p), head(p), 0.14), ears(p), 0.07), eyes(p), 0.05)


def colour(p: Array, normals: Array) -> Array:
    """Return RGB in [0, 1], (n, 3)."""
    tone = 0.5 + 0.5 * np.tanh(brushed(p, flow, 0.4, 0.07, 21) * 0.8)
    patch = noise(p * 2.2, 22)
    coat = _mix(_rgb(0x7A5436), _rgb(0xC49A6C), np.clip(0.15 + 0.65 * tone + 0.25 * patch, 0, 1))
    pale = _rgb(0xF3E9DA) * (0.93 + 0.07 * tone[:, None])
    q = (p - HEAD) @ HEAD_TURN
    below = _step(ellipsoid(p, at(0, 0.72, 0.62), at(0.30, 0.62, 0.34)), 0.10, -0.06)
    below = np.maximum(below, _step(ellipsoid(p, at(0.02, 0.44, -1.16), at(0.22, 0.22, 0.22)), 0.05, 0.0))
    below = np.maximum(below, _step(ellipsoid(q, at(0, -0.24, 0.42), at(0.26, 0.17, 0.26)), 0.06, -0.05))
    below = np.maximum(below, 0.7 * _step(eyes(p), 0.06, 0.03))
    paws = np.maximum(_step(p[:, 1], 0.26, 0.10), 0.0) * _step(p[:, 2], 0.15, 0.45)
    out = _mix(coat, pale, np.maximum(below, 0.75 * paws))
    out = _paint_ears(out, p, normals)
    out = _mix(
        out,
        _rgb(0xC98277),
        _step(np.linalg.norm((q - at(0, -0.04, 0.635)) / at(1.3, 1, 1), axis=1), 0.075, 0.05),
    )
    out = _mix(out, _rgb(0x17110E), _step(eyes(p), 0.022, 0.008))
    glint = np.min(
        [np.linalg.norm(q - at(0.30 * side + 0.02, 0.125, 0.285), axis=1) for side in (-1.0, 1.0)], axis=0
    )
    out = _mix(out, _rgb(0xFFFFFF), _step(glint, 0.045, 0.02))
    moss = _mix(_rgb(0x55702F), _rgb(0x93A64E), np.clip(0.5 + 0.9 * noise(p * 3.0, 23), 0, 1))
    moss = _mix(moss, _rgb(0x6E5B45), _step(normals[:, 1], 0.15, -0.2))
    return _mix(out, moss, _step(furred(p), 0.008, 0.03))


def _paint_ears(out: Array, p: Array, normals: Array) -> Array:
    hollow = np.zeros(len(p))
    tip = np.zeros(len(p))
    for curve, facing in EARS:
        apart = np.linalg.norm(p[:, None] - curve, axis=2)
        nearest = apart.argmin(axis=1)
        on = (apart.min(axis=1) < 0.30) & (ears(p) < 0.03) & (nearest > 1)
        tip = np.maximum(tip, on * _step(nearest + 0.0, 8.5, 11.5))
        hollow = np.maximum(
            hollow,
            on * _step(normals @ (HEAD_TURN @ facing), 0.25, 0.65) * _step(apart.min(axis=1), 0.16, 0.08),
        )
    out = _mix(out, _rgb(0xDDA392), 0.85 * hollow)
    return _mix(out, _rgb(0x3A2A20), 0.85 * tip)


def _step(x: Array, zero: float, one: float) -> Array:
    t = np.clip((x - zero) / (one - zero), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _mix(a: Array, b: Array, share: Array) -> Array:
    return a + (b - a) * np.reshape(share, (-1, 1))


def _rgb(code: int) -> Array:
    return np.array([code >> 16, code >> 8 & 255, code & 255]) / 255.0
