"""The limits by which seams are found and accepted; each one is said here and nowhere else.

`SeamOptions` uses them as defaults. What only one step needs (samples, rounds, the shape of a fastener) is beside that
step.
"""

from __future__ import annotations

from enum import Enum

from wpcal.brep.contact import CONTACT_GAP_MM

LEAST_SEAM_MM = 5.0
"""Least length of an accepted seam, unless `SeamOptions.min_length_mm` says otherwise. A shorter run is a step in a
machined part or a sliver: the end of an 8 mm plate is the shortest weld in use."""
LENGTH_ROUND_OFF_MM = 1e-3
"""A seam that is shorter by less is as long as it must be: kernels place vertices within this."""
LEAST_CANDIDATE_MM = 1.0  #: A shorter contact is not even a candidate: an arc needs more to start.
LEAST_CHANGE_MM = 3.0
"""The side of a weld does not change on a shorter way: a small fillet weld has legs of 3 mm, and covers it."""


class Level(Enum):
    """How sure a candidate must be to be accepted; the value is its least confidence, the rest the risk."""

    STRICT = 0.9
    """Only what is sure: members in contact, or running into each other, against which nothing speaks but a gap of up
    to 40 % of the allowed one."""
    USUAL = 0.8
    """Also edges and beads inside one solid, wider gaps, pins in holes. A false seam costs a click, a missed one is a
    missing weld."""
    GENEROUS = 0.05
    """Also what one doubtful finding speaks against: bolts, a name, a short length. Not what no torch reaches, nor a
    solid that has the shape of a fastener or is known not to be metal."""


MOST_BRIDGE_MM = 5.0
"""Contacts in one line are welded in one run across interruptions of at most this length: the slit beside a tab, a
relief hole."""
GAP_SHARE = 2.5e-3
"""On parts smaller than 200 mm the gap is this share of the diagonal: 0.5 mm would join everything on a small part."""
GAP_ROUND_OFF_MM = 1e-6
"""A gap that is as wide as allowed may be wider by round-off: a hole of 30.5 mm round a bar of 30 mm."""
FLUSH_MM = 0.02
"""An edge nearer than this to the boundary of a face runs along it: twice the sag of the boundary's polylines."""
OPPOSED_COS = -0.87
"""Two faces are in contact only if the cosine between their outward normals is below this (within 30 degrees of
opposite)."""
NEAR_GAPS = 3.0
"""Curves nearer to each other than this many gaps are one seam: each may be a gap away from the other member, and there
may be a gap between the two."""
WIDE_GAPS = 2.0
"""A gap that stays the same along the whole edge may be this many times as wide as the usual one, 1 mm, and where none
is found again this many times as wide. A pipe that was cut short, or a root gap, is that wide; what only comes near is
rarely so along a whole edge."""
MEETING_MM = 1.0
"""Ends nearer than this meet: an arc goes on over a gap of 1 mm, and the torch goes straight from one to the other."""


def usual_gap_mm(size_mm: float) -> float:
    """Return the largest gap between two members in contact on a part of a size (diagonal, mm), in mm.

    >>> usual_gap_mm(1000.0), usual_gap_mm(100.0)
    (0.5, 0.25)
    """
    return min(CONTACT_GAP_MM, GAP_SHARE * size_mm)
