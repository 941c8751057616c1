"""Moving the points of a surface so that their coordinates carry bits, while its canonical frame stays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.coding.keyed_code import LENGTH
from meshmark.geometry.areas import area_vectors, face_areas
from meshmark.geometry.joints import joints_of
from meshmark.geometry.plane_patches import PlanePatches
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray
from meshmark.ownership.points.balance import balanced
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.coordinates import ease_of, held
from meshmark.ownership.points.frame_moments import frame_moments
from meshmark.ownership.points.giving_way import Giving, GivingAlone, GivingTogether, PlanesKept
from meshmark.ownership.points.moments_apart import moments_apart, stretched
from meshmark.ownership.points.parameters import LIFTED, SLIDING
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_lattice import PointKeys, PointLattice
from meshmark.ownership.points.targets import Message, Quantiser, nearest_places

__all__ = ["PointShaping"]

# Passes: what carries is what an extraction will find on the moved surface.
PASSES = 3
# Newton passes for the frame, in each pass and in the last, and the error with which they may stop.
FRAME_PASSES = (2, 12)
FRAME_ERROR = 1e-7
# Directions of the frame that give way less than this share of the most are left alone.
SINGULAR = 1e-12
# Faces with twice this area over the mean have a normal that can turn.
SOUND = 1e-9
# Further passes, for points that had to be let go: of folded faces, and those moved too far for the frame's sake.
FURTHER = 5
# Share of the faces that fold over from which a choice is given up.
HOPELESS = 0.02
# Cost of leaving the planes of a star where plane patches are kept as a whole, over that where they are not.
BENDING = 0.01
# Share of the largest displacement from which points are held back.
NEARLY = 0.7


class PointShaping:
    """A surface whose points are to carry bits.

    surface: to be marked. lattice: of its label. message: what coordinates say. largest: displacement of a point at
    most, over the diagonal; budget: RMS displacement, over the diagonal. still: (p,) points that stay where they
    are; none where it is left out. holds_area: the surface keeps its area as well as its frame. aims: (p, 3) scene
    points from which the places of the points are told, of the surface where left out. planes: patches that are to
    stay plane.
    """

    def __init__(
        self,
        surface: Surface,
        lattice: PointLattice,
        message: Message,
        *,
        largest: float,
        budget: float,
        still: NDArray[np.bool_] | None = None,
        holds_area: bool = False,
        aims: FloatArray | None = None,
        planes: PlanePatches | None = None,
    ) -> None:
        self._surface, self._lattice = surface, lattice
        self._message = message
        self._still = np.zeros(len(surface.points), bool) if still is None else still
        self._patches = planes if planes is not None and len(planes.point) else None
        self._frame = surface.frame
        self._start = Carried.of(surface, self._frame)
        self._points = self._frame.to_canonical(surface.points)
        self._largest = largest * surface.diagonal / self._frame.scale
        moments = moments_apart(self._frame, budget * surface.diagonal / self._frame.scale)
        self._holds_area = holds_area
        area = [np.log(face_areas(self._points, surface.faces).sum())] if holds_area else []
        self._goal = np.concatenate([np.zeros(3), moments, np.zeros(3), area])
        # Stretching the whole keeps planes plane; what it leaves of the moments, some points make up for.
        self._stretched = stretched(self._points, self._frame, moments)
        self._stretched[self._still] = self._points[self._still]
        self._aims = None if aims is None else self._frame.to_canonical(aims)

    @cached_property
    def _joints(self) -> csr_array:
        """(p, p): how points follow others, see `joints_of`."""
        return joints_of(self._surface)

    @cached_property
    def _is_jointed(self) -> bool:
        """Whether any point follows another."""
        joints = self._joints
        return joints.nnz != joints.shape[0] or bool((joints.diagonal() != 1.0).any())

    def _followed(self, motion: FloatArray) -> FloatArray:
        """Return how all points move (p, 3) under the motions of those that follow none."""
        return np.asarray(self._joints @ motion) if self._is_jointed else motion

    @cached_property
    def _planes(self) -> PlanesKept | None:
        if self._patches is None:
            return None
        return PlanesKept.of(self._points, self._patches, self._joints if self._is_jointed else None)

    @cached_property
    def _pull(self) -> csr_array:
        """(p, p): the joints transposed."""
        return self._joints.T.tocsr()

    @cached_property
    def _keys(self) -> PointKeys:
        return self._lattice.keys(self._lattice.cubes(self._points))

    @cached_property
    def _coordinates(self) -> tuple[NDArray[np.bool_], ...]:
        """(p, 3) for each of `MODES`: the coordinates that carry before anything moves."""
        return self._start.turned(np.eye(3), self._keys.first)

    def expected(self, choice: Choice) -> tuple[int, float]:
        """Return how many code bits a choice carries before anything moves, and the RMS it will take, about.

        The RMS displacement is over the diagonal.
        """
        coordinates, room = self._coordinates[choice.mode], self._start.at(choice.step)
        carries = choice.carrying(coordinates, room, self._keys.draw) & ~self._still[:, None]
        index = self._keys.code_index[carries]
        square = self._strain[carries].sum() / max(len(carries), 1) * choice.step**2 / 12.0
        rms = float(np.sqrt(square) * self._frame.scale / self._surface.diagonal)
        return int(np.count_nonzero(np.bincount(index, minlength=LENGTH))), rms

    @cached_property
    def _strain(self) -> FloatArray:
        """(p, 3) square of the motion for a unit of change of each coordinate."""
        ease = self._start.ease
        own = np.einsum("pii->pi", ease)
        return np.asarray((ease**2).sum(axis=1) / own**2)

    def shaped(self, choice: Choice) -> FloatArray | None:
        """Return the points (p, 3), in scene units, moved as chosen; None where faces would fold over."""
        surface, start, joints = self._surface, self._stretched, self._joints
        before = _normals(start, surface.faces)
        quantiser = Quantiser(lattice=self._lattice, message=self._message, step=choice.step)
        frozen = (joints.diagonal() != 1.0) | (np.diff(joints.indptr) != 1) | self._still
        yields = np.minimum(self._start.stars.height / self._largest, 1.0) ** 2
        points, motion = start, np.zeros_like(start)
        for number in range(PASSES + FURTHER):
            carried = Carried.of(surface.moved(self._frame.to_scene(points)), self._frame)
            cost = carried.stars.tensor + SLIDING * np.eye(3)
            ease = carried.ease
            keys = self._lattice.keys(self._lattice.cubes(points))
            carries = carried.carrying(choice, keys) & ~frozen[:, None]
            follow, _ = held(ease, carries)
            motion, done = nearest_places(start, follow, quantiser, self._aims)
            done &= carries.any(axis=1) & (np.linalg.norm(motion, axis=1) <= self._largest)
            motion[~done] = 0.0
            carries &= done[:, None]
            follow, rest = held(ease, carries)
            giving = self._giving(carried, carries, rest, np.where(frozen, 0.0, yields))
            motion = giving.flattened(motion)
            off = self._off(motion, giving)
            further = balanced(
                motion,
                follow=follow,
                cost=cost,
                carries=carries,
                step=choice.step,
                gradient=off.gradient,
                error=off.error,
                price=np.asarray(
                    np.linalg.pinv(off.system, rcond=SINGULAR, hermitian=True), dtype=np.float64
                ),
            )
            stays = (self._lattice.cubes(start + further) == self._lattice.cubes(start + motion)).all(axis=1)
            motion = np.where(stays[:, None], further, motion)
            motion = self._framed(giving.flattened(motion), giving, FRAME_PASSES[number >= PASSES - 1])
            points = start + self._followed(motion)
            folded = (np.einsum("ij,ij->i", before, _normals(points, surface.faces)) < LIFTED) & (
                (before**2).sum(axis=1) > 0.0
            )
            far = np.linalg.norm(points - self._points, axis=1) / self._largest
            if folded.mean() > HOPELESS:
                return None
            if folded.any():
                frozen = frozen | _touched(joints, np.unique(surface.faces[folded]), len(points))
            elif far.max() > 1.0:
                # Those that go too far for their own sake stay where they are, others give way less. At first
                # planes take many along, which then only give way less.
                if self._planes is None or number >= PASSES:
                    own = np.flatnonzero((far > 1.0) & carries.any(axis=1))
                    frozen = frozen | _touched(joints, own, len(points))
                yields = np.where(
                    far > NEARLY, yields * (NEARLY / np.maximum(far, NEARLY)) ** 2 / 2.0, yields
                )
            elif number >= PASSES - 1:
                return self._in_scene(points)
        return None

    def _giving(
        self, carried: Carried, carries: NDArray[np.bool_], rest: FloatArray, share: FloatArray
    ) -> Giving:
        """Return how points give way whose set coordinates (p, 3) stay.

        rest: (p, 3, 3) inverse cost of their other motions; share: (p,) of it that is allowed.
        """
        if self._planes is None:
            return GivingAlone(rest * share[:, None, None])
        rest = held(ease_of(BENDING * carried.stars.tensor), carries)[1]
        return GivingTogether(rest * share[:, None, None], self._planes)

    def _in_scene(self, points: FloatArray) -> FloatArray:
        """Return canonical points (p, 3) in scene units; those that did not move or are unused stay exactly."""
        moved = (points != self._points).any(axis=1) & self._surface.used
        return np.where(moved[:, None], self._frame.to_scene(points), self._surface.points)

    def _framed(self, motion: FloatArray, giving: Giving, passes: int) -> FloatArray:
        """Return the motion (p, 3) with what points give way by added until the frame is as wanted."""
        for _ in range(passes):
            off = self._off(motion, giving)
            if np.abs(off.error).max() < FRAME_ERROR:
                break
            step = np.linalg.pinv(off.system, rcond=SINGULAR, hermitian=True) @ off.error
            motion = motion - np.tensordot(step, off.given, 1).T
        return motion

    def _moments(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        return frame_moments(points, self._surface.faces, with_area=self._holds_area)

    def _off(self, motion: FloatArray, giving: Giving) -> _Off:
        """Return how far the moments are off under a motion."""
        values, gradient = self._moments(self._stretched + self._followed(motion))
        count = len(values)
        pulled = gradient.transpose(0, 2, 1)
        if self._is_jointed:
            by_free = self._pull @ pulled.reshape(-1, len(motion)).T
            pulled = np.ascontiguousarray(by_free.T).reshape(pulled.shape)
        given = giving.given(pulled)
        return _Off(
            gradient=pulled.transpose(0, 2, 1),
            error=values - self._goal,
            given=given,
            system=pulled.reshape(count, -1) @ given.reshape(count, -1).T,
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Off:
    """How far q moments that are held are off.

    gradient: (q, p, 3) change of each by the coordinates of the points that follow none. error: (q,).
    given: (q, 3, p) how points give way to a unit of force along each gradient; system: (q, q) how the moments
    change then.
    """

    gradient: FloatArray
    error: FloatArray
    given: FloatArray
    system: FloatArray


def _touched(joints: csr_array, points: IntArray, count: int) -> NDArray[np.bool_]:
    """Return (count,): points that these follow or are."""
    touched = np.zeros(count, bool)
    touched[points] = True
    touched[joints[points].indices] = True
    return touched


def _normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return unit normals (m, 3) of the faces, 0 of slivers."""
    vectors = area_vectors(points, faces)
    length = np.linalg.norm(vectors, axis=1)
    sound = length > SOUND * max(float(length.mean()), 1e-300)
    return np.asarray(np.where(sound[:, None], vectors / np.maximum(length, 1e-300)[:, None], 0.0))
