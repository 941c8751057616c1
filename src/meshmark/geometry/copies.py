"""Copies of one mesh in a scene that says nothing of them: connected parts that are alike up to a similarity.

A scene shows a mesh of several parts (a trunk and its leaves) with all of them in the same places about each
other. So the largest parts are compared, and what else lies about the copies where it lies about the first belongs
to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.geometry.affine import Affine
from meshmark.geometry.congruence import Tolerance, congruence, matched
from meshmark.geometry.connected import Parts
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.partial_congruence import partial_congruence
from meshmark.mesh import FloatArray, IntArray

__all__ = ["FIRST_LARGEST", "Copies", "find_copies"]

FIRST_LARGEST = 0.999
"""Of several copies the first is taken that is at least this share of the size of the largest."""
# Parts looked at where one should lie: several may have the same middle.
_NEAR = 4
# Comparisons of parts that fail, after which no more are made: of many parts that are nearly alike few are copies.
_MOST_FAILED = 300
# Moments over size squared of copies that were changed, or cut, differ by less than this.
_ALIKE_EDITED, _ALIKE_CUT = 0.05, 0.3
# Number of the largest parts that are compared with each other for copies that were changed, and the largest factor
# between the numbers of points of such a copy and its original.
_MOST_EDITED, _MOST_LOST = 16, 3.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Copies:
    """Which points (p,) are copies.

    original: (p,) the point that each is a copy of, itself where it is none. place: (p,) the number of the map, in
    `maps`, that takes the original to it; 0, the identity, of what is no copy.
    """

    original: IntArray
    place: IntArray
    maps: tuple[Affine, ...]


def find_copies(
    points: FloatArray, parts: Parts, least: int, tolerance: Tolerance, *, edited: str = "none"
) -> Copies | None:
    """Return what copies there are among the parts of a surface, None where there are none.

    points: (p, 3); parts: of their surface. least: points of the smallest part that is taken for
    a copy by itself; smaller ones are where they lie like the others of a copy. edited: "moved" for parts of which
    points were moved since they were copies, "cut" also for those with other faces; their points are copies of the
    nearest ones.
    """
    groups = parts.alike(least)
    if sum(map(len, groups)) < 2 or not (edited == "cut" or any(len(group) > 1 for group in groups)):
        return None
    search = _Search(points, parts, tolerance)
    for group in groups:
        search.compare(group)
    if edited != "none":
        search.compare_edited(np.concatenate(groups)[:_MOST_EDITED], cut=edited == "cut")
    return search.result()


class _Search:
    """The copies found so far, and the parts that are known to be none."""

    def __init__(self, points: FloatArray, parts: Parts, tolerance: Tolerance) -> None:
        self._points, self._parts, self._tolerance = points, parts, tolerance
        self._tree = kd_tree(parts.middle)
        self._first = np.zeros(len(parts), bool)
        self._copy = np.zeros(len(parts), bool)
        self._original = np.arange(len(points))
        self._place = np.zeros(len(points), np.int64)
        self._maps = [Affine.identity()]
        self._failed = 0

    def result(self) -> Copies | None:
        """Return what was found."""
        return (
            Copies(original=self._original, place=self._place, maps=tuple(self._maps))
            if self._copy.any()
            else None
        )

    def compare(self, group: IntArray) -> None:
        """Find the copies among parts of equally many points and faces, and what belongs to them."""
        left = [part for part in group if not (self._copy[part] or self._first[part])]
        while len(left) > 1 and self._failed < _MOST_FAILED:
            one = left[0]
            members, maps = [int(one)], [Affine.identity()]
            for other in left[1:]:
                found = congruence(self._points, self._parts, (int(one), int(other)), self._tolerance)
                if found is None:
                    self._failed += 1
                    continue
                members.append(int(other))
                maps.append(found)
            left = [part for part in left if part not in set(members)]
            if len(members) > 1:
                self._take_group(members, maps)

    def compare_edited(self, group: IntArray, *, cut: bool) -> None:
        """Find which of these parts were copies of another one before they were changed."""
        for part in group[::-1]:
            others = [other for other in group if other != part and not self._copy[other]]
            others.sort(key=lambda other: (not self._first[other], other))
            if self._copy[part] or self._first[part]:
                continue
            for other in others:
                if not self._comparable(part, other, cut):
                    continue
                ends = (int(other), int(part))
                affine = partial_congruence(self._points, self._parts, ends, self._tolerance)
                if affine is None:
                    continue
                scale = abs(np.linalg.det(affine.linear)) ** (1 / 3)
                if FIRST_LARGEST * scale > 1.0 and not self._first[other]:
                    ends, affine = ends[::-1], affine.inverse()
                self._take_edited(ends, affine)
                break

    def _comparable(self, part: int, other: int, cut: bool) -> bool:
        """Return whether one of two parts may be the other one after a change."""
        counts, moments = self._parts.counts, self._parts.moments
        if (counts[part] == counts[other]).all():
            return bool(np.abs(moments[part] - moments[other]).max() < _ALIKE_EDITED)
        share = counts[part, 0] / counts[other, 0]
        near = np.abs(moments[part] - moments[other]).max() < _ALIKE_CUT
        return bool(cut and near and 1.0 / _MOST_LOST < share < _MOST_LOST)

    def _take_edited(self, ends: tuple[int, int], affine: Affine) -> None:
        here = self._points[self._parts.points(ends[1])]
        there = affine(self._points[self._parts.points(ends[0])])
        ordered = len(here) == len(there) and np.median(np.abs(here - there)) <= self._most(ends[1])
        pairs = np.arange(len(here)) if ordered else np.asarray(kd_tree(there).query(here)[1], np.int64)
        self._take(*ends, pairs, len(self._maps))
        self._first[ends[0]] = True
        self._maps.append(affine)
        self._follow(ends[0], [len(self._maps) - 1])

    def _most(self, part: int) -> float:
        return float(self._tolerance(self._points, self._parts.size[[part]])[0])

    def _take_group(self, members: list[int], maps: list[Affine]) -> None:
        """Take one of these parts, of which the maps take the first one to each, for the original of the others."""
        scale = np.array([abs(np.linalg.det(affine.linear)) ** (1 / 3) for affine in maps])
        best = int(np.argmax(scale >= FIRST_LARGEST * scale.max()))
        first, back = members[best], maps[best].inverse()
        self._first[first] = True
        new = []
        for number, part in enumerate(members):
            if number == best:
                continue
            affine = maps[number].after(back)
            pairs = matched(self._points, self._parts, (first, part), affine, self._tolerance)
            if pairs is not None and self._take(first, part, pairs, len(self._maps)):
                new.append(len(self._maps))
                self._maps.append(affine)
        self._follow(first, new)

    def _take(self, first: int, part: int, pairs: IntArray, place: int) -> bool:
        if self._copy[part] or self._first[part]:
            return False
        self._copy[part] = True
        rows = self._parts.points(part)
        self._original[rows] = self._parts.points(first)[pairs]
        self._place[rows] = place
        return True

    def _follow(self, first: int, places: list[int]) -> None:
        """Find the other parts that lie about the copies as they do about the first, nearest to it first."""
        far = np.linalg.norm(self._parts.middle - self._parts.middle[first], axis=1)
        order = np.argsort(far, kind="stable")
        order = order[~self._copy[order] & (order != first)]
        there = {place: self._candidates(order, self._maps[place]) for place in places}
        for row, part in enumerate(order):
            if self._copy[part]:
                continue
            for place in places:
                for other in there[place][row]:
                    if other < 0 or other == part or self._copy[other] or self._first[other]:
                        continue
                    ends = (int(part), int(other))
                    pairs = matched(self._points, self._parts, ends, self._maps[place], self._tolerance)
                    if pairs is not None:
                        self._take(*ends, pairs, place)
                        self._first[part] = True
                        break

    def _candidates(self, parts: IntArray, affine: Affine) -> IntArray:
        """Return (n, k): parts that may lie where the map takes each of these, -1 for none."""
        count = min(_NEAR, len(self._parts))
        if not len(parts):
            return np.empty((0, count), np.int64)
        near = self._tree.query(affine(self._parts.middle[parts]), k=count)
        off, found = (np.asarray(item).reshape(-1, count) for item in near)
        scale = abs(np.linalg.det(affine.linear)) ** (1 / 3)
        close = off <= self._tolerance(self._points, scale * self._parts.size[parts])[:, None]
        same = (self._parts.counts[found] == self._parts.counts[parts][:, None]).all(axis=2)
        return np.where(close & same, found, -1)
