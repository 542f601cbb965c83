"""A weld seam: consecutive pieces of edges, the faces that they join, and frames along them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.core.same_bits import poses, product
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam_edit import Candidate, SeamEdit

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


class JointType(Enum):
    """How two members meet (ISO 17659)."""

    TEE = "tee"
    LAP = "lap"
    BUTT = "butt"
    CORNER = "corner"
    EDGE = "edge"
    UNKNOWN = "unknown"


class WeldType(Enum):
    """The weld in the joint (AWS A3.0)."""

    FILLET = "fillet"
    GROOVE = "groove"
    FLARE_BEVEL = "flare-bevel groove"  #: Between a radius and a flat face that runs onto it.
    FLARE_V = "flare-V groove"  #: Between two radii.
    UNKNOWN = "unknown"


class SeamSource(Enum):
    """How a candidate was found."""

    CONTACT = "contact of two solids"
    SECTION = "section of two solids that run into each other"
    CONCAVE = "concave edge inside one solid"
    MITRE = "mitre of tubes inside one solid"
    BEAD = "modelled bead or round inside one solid"
    DRAWN = "corner that a modelled bead fills"
    FLARE = "groove between a radius and another member"
    MARKED = "marked or picked edge"
    ADDED = "edge added to those that are found"

    @property
    def is_chosen(self) -> bool:
        """Whether a person chose the edge: then it is a seam, whatever the findings."""
        return self in (SeamSource.MARKED, SeamSource.ADDED)

    @property
    def is_filled(self) -> bool:
        """Whether material that stands for the weld is in front of the seam."""
        return self in (SeamSource.BEAD, SeamSource.DRAWN)


@dataclass(frozen=True, slots=True, eq=False)
class SeamPieces(Columns):
    """k pieces of edges along which two faces can be welded."""

    edge: IntArray  #: shape (k,).
    #: `t0`, `t1`: shape (k,). Parameters at the start and the end of each piece; t1 < t0 runs against the edge.
    t0: FloatArray
    t1: FloatArray
    wall: IntArray  #: shape (k,). The face that the edge bounds and that leads away from the joint.
    base: IntArray  #: shape (k,). The other face of the joint.
    gap_mm: FloatArray  #: shape (k, 3). Least, mean and largest distance between the edge and the base.

    def __len__(self) -> int:
        return len(self.edge)

    def reversed_where(self, flip: BoolArray) -> SeamPieces:
        """Return the same pieces, reversed where `flip` is true; shape (k,)."""
        t0, t1 = np.where(flip, self.t1, self.t0), np.where(flip, self.t0, self.t1)
        return SeamPieces(self.edge, t0, t1, self.wall, self.base, self.gap_mm)

    def backwards(self) -> SeamPieces:
        """Return the same run from its end to its start."""
        return self.select(np.arange(len(self))[::-1]).reversed_where(np.ones(len(self), dtype=bool))

    @staticmethod
    def none() -> SeamPieces:
        """Return no pieces."""
        rows, t = np.zeros(0, dtype=np.int64), np.zeros(0)
        return SeamPieces(rows, t, t, rows, rows, np.zeros((0, 3)))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SeamFrames(Columns):
    """The frames along a seam (DESIGN §3): x travel, z out of the joint, y = z × x."""

    s_mm: FloatArray  #: shape (n,). Arc length from the start.
    p: FloatArray  #: shape (n, 3). Origins, mm.
    R: FloatArray  #: shape (n, 3, 3). Columns are the axes x, y, z.
    angle_rad: FloatArray  #: shape (n,). Between the outward normals of the two faces.
    frame: str = "part"  #: The coordinates of `p` and `R`.

    def __len__(self) -> int:
        return len(self.s_mm)

    def __repr__(self) -> str:
        return f"SeamFrames({len(self)} in {self.frame}, {float(np.ptp(self.s_mm)) if len(self) else 0.0:.1f} mm)"

    @property
    def matrices(self) -> FloatArray:
        """Homogeneous matrices, shape (n, 4, 4), mm: each carries points of the seam's frame to `frame`."""
        return poses(self.R, self.p)

    @property
    def rotations(self) -> Rotation:
        """The n rotations for SciPy, which converts them to any other form; each carries the seam's axes to `frame`."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_matrix(self.R)

    def axes_at(self, s_mm: FloatArray) -> FloatArray:
        """Return the axes at lengths of shape (m,), shape (m, 3, 3); between two frames they turn evenly."""
        from scipy.spatial.transform import Slerp

        return np.asarray(Slerp(self.s_mm, self.rotations)(np.clip(s_mm, self.s_mm[0], self.s_mm[-1])).as_matrix())

    def moved(self, transform: RigidTransform) -> SeamFrames:
        """Return the frames in the target frame of `transform`."""
        return SeamFrames(
            self.s_mm, transform.apply(self.p), product(transform.R, self.R), self.angle_rad, frame=transform.target
        )


@dataclass(frozen=True, slots=True)
class FlareGroove:
    """The cross-section of a flare groove in the middle of its seam."""

    depth_mm: float  #: From the root, where the two surfaces are nearest, to where the first of the two faces ends.
    opening_mm: float  #: Distance between the two faces there.
    root_mm: float  #: Distance of the seam from the root, along the groove.


@dataclass(frozen=True, slots=True)
class Hiding:
    """What a torch would reach of a seam if a solid beside it were not there."""

    solid: str
    length_mm: float  #: This much of the seam would be free.
    is_loose: bool  #: No face of the solid is near another solid: it may be a fixture, or a part that is mounted later.


@dataclass(frozen=True, slots=True)
class OtherTorch:
    """A torch that comes with wpcal and reaches a seam which the stated torch does not reach."""

    name: str  #: As `--torch` takes it.
    wire_mm: float  #: The wire that it needs, from the tip to the mouth of the nozzle.


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding that speaks against a candidate."""

    rule: str  #: Key of the rule (`judge.rules.Rule`): ``not-reached``.
    factor: float  #: The score is multiplied by it (`rules.confidence_of`).
    text: str  #: The finding in words, for people.
    solid: str = ""  #: Name of the solid that it is about; empty if it is about the candidate.


class NamedSolids(str):
    """A reason that names solids, so that it can be told of the same seam in a copy of these solids."""

    words: str
    solids: tuple[str, ...]

    def __new__(cls, words: str, solids: tuple[str, ...]) -> NamedSolids:
        """Put the names into the words."""
        told = super().__new__(cls, words.format(", ".join(solids)))
        told.words, told.solids = words, solids
        return told

    def told_of(self, names: Mapping[str, str]) -> NamedSolids:
        """Return the same reason about other solids: their names, by the names here."""
        return NamedSolids(self.words, tuple(names[solid] for solid in self.solids))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Seam:
    """One seam: a curve with a direction, which a torch can follow in one run."""

    name: str  #: ``W1``, ``W2``, … by the place of the start.
    joint: JointType
    weld: WeldType
    solids: tuple[str, ...]  #: Names of the solids that it joins; one name for an edge inside a solid.
    pieces: SeamPieces  #: In order, each in the direction of the seam.
    closed: bool
    length_mm: float
    reachable: bool  #: Whether a torch can reach it: enough rays out of the joint leave the part.
    accepted: bool  #: Whether it is to be welded.
    reasons: tuple[str, ...]  #: Why it is a candidate, and what else was found out about it.
    #: Empty until they are computed.
    frames: SeamFrames = field(
        default_factory=lambda: SeamFrames(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0))
    )
    source: SeamSource = SeamSource.CONTACT
    confidence: float = 1.0  #: From 0 to 1: how sure the rules are that this is a weld (`judge.evidence`).
    findings: tuple[Finding, ...] = ()  #: What speaks against it, the strongest first: the reasons for a rejection.
    #: The candidate as it was found; None for a seam that does not come from a part.
    candidate: Candidate | None = None
    edit: SeamEdit | None = None  #: What a person decided about it.
    #: Names of the solids in whose material the tip or the wire would be. Such a stretch is never welded.
    inside: tuple[str, ...] = ()
    #: Names of the solids that a torch meets at this stretch with every lean that was tried.
    blocked_by: tuple[str, ...] = ()
    #: shape (n, 2). Work and travel angle at each of the n frames with which the torch meets nothing; NaN where it
    #: always meets something. None: not felt.
    lean_rad: FloatArray | None = None
    #: shape (n,). How far a torch with a bent neck is turned about the wire at each frame
    #: (`judge.torch_neck.bend_directions`); NaN where it always meets something. None: 0 everywhere.
    spin_rad: FloatArray | None = None
    #: How much longer than usual the wire must be, from its tip to the mouth of the nozzle, for the torch to reach the
    #: seam.
    more_wire_mm: float = 0.0
    #: What the torch would reach of a blocked stretch without one of the solids in its way.
    hiding: tuple[Hiding, ...] = ()
    other_torch: OtherTorch | None = None  #: A torch that reaches the seam, if the stated one does not.
    groove: FlareGroove | None = None  #: The cross-section of a flare groove; None for another weld.
    bead_mm: float | None = None  #: The throat of the bead or round that is drawn in it.
    #: The name of the seam of which this is a wrap: it goes across the end of a plate, beside that seam. None for any
    #: other seam.
    wrap_of: str | None = None

    def __repr__(self) -> str:
        what = "accepted" if self.accepted else "not accepted"
        return f"Seam({self.name}: {self.joint.value}, {' + '.join(self.solids)}, {self.length_mm:.1f} mm, {what})"

    @property
    def against(self) -> tuple[str, ...]:
        """The findings in words."""
        return tuple(finding.text for finding in self.findings)

    @property
    def gap_mm(self) -> tuple[float, float, float]:
        """Least, mean and largest gap along the seam, mm."""
        gap = self.pieces.gap_mm
        return float(gap[:, 0].min()), float(gap[:, 1].mean()), float(gap[:, 2].max())
