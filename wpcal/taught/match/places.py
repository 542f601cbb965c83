"""The places of features: several features at one place are one place to touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.linked import linked_groups, near_pairs
from wpcal.taught.features.reference import POINT_KINDS, FeatureKind, ReferenceFeature

SAME_MM = 0.01  #: Features nearer than this are one place: a hole and its rim, the corners of two plates that meet.
SAID_FIRST = (
    FeatureKind.HOLE,
    FeatureKind.VERTEX,
    FeatureKind.SPHERE,
    FeatureKind.CIRCLE,
    FeatureKind.BOSS,
    FeatureKind.EDGE_END,
    FeatureKind.EDGE_MIDPOINT,
    FeatureKind.VIRTUAL_CORNER,
    FeatureKind.SLOT,
    FeatureKind.AXIS,
    FeatureKind.PLANE,
)
"""Of several features at one place, the kind that comes first here gives the place its name."""
HARD_TO_FIND = (FeatureKind.EDGE_MIDPOINT, FeatureKind.EDGE_END)  #: Places on an edge that cannot be felt.


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Where features are."""

    p: FloatArray  #: shape (k, 3). In `part`, mm; no two within `SAME_MM`.
    names: tuple[str, ...]  #: length k. The name to say for each.
    features: tuple[tuple[ReferenceFeature, ...], ...]  #: length k. All features there, that name's first.

    @classmethod
    def of(cls, features: Sequence[ReferenceFeature]) -> Places:
        """Join features that lie at one place."""
        if not features:
            return cls(frozen(np.empty((0, 3))), (), ())
        p = np.array([feature.p_mm for feature in features])
        label = linked_groups(len(p), *near_pairs(p, SAME_MM).T)
        groups: list[list[ReferenceFeature]] = [[] for _ in range(label.max() + 1)]
        for feature, group in zip(features, label, strict=True):
            groups[group].append(feature)
        ordered = [tuple(sorted(group, key=lambda f: SAID_FIRST.index(f.kind))) for group in groups]
        return cls(frozen([g[0].p_mm for g in ordered]), tuple(g[0].name for g in ordered), tuple(ordered))

    def of_kinds(self, kinds: Sequence[FeatureKind]) -> IntArray:
        """Return the places that hold a feature of one of these kinds."""
        return np.array([k for k, g in enumerate(self.features) if any(f.kind in kinds for f in g)], dtype=np.int64)

    def easy_to_touch(self, most: int) -> IntArray:
        """Return at most `most` places, spread over the list; points on edges only if there is nothing else."""
        rows = self.of_kinds([kind for kind in POINT_KINDS if kind not in HARD_TO_FIND])
        rows = rows if len(rows) else np.arange(len(self.p))
        return rows[np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).astype(np.int64))]

    def holding(self, name: str) -> int:
        """Return the place of the feature of this name."""
        return next(k for k, group in enumerate(self.features) if any(f.name == name for f in group))
