"""The rules by which a candidate is judged: one table, which `docs/seams.md` shows.

The score of a candidate is that of its source, times the factor of every finding. The factors are set by hand and are
a ranking: each says on which side of the three thresholds (`Level`) a candidate is that has this finding and no other.
Fitted ones are worse on parts of authors that they were not fitted to (`docs/benchmark.md`). What is fitted is how
often candidates of a score are welds (`confidence_of`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.seam.seam import Finding, SeamSource

PRIOR = {
    SeamSource.CONTACT: 0.95,
    SeamSource.SECTION: 0.9,
    SeamSource.CONCAVE: 0.95,
    SeamSource.MITRE: 0.95,
    SeamSource.BEAD: 0.7,
    SeamSource.DRAWN: 0.95,
    SeamSource.FLARE: 0.95,
    SeamSource.MARKED: 1.0,
    SeamSource.ADDED: 1.0,
}
"""Score before any finding. Of the candidates of `docs/benchmark.md` without a finding, 95 % of the concave edges
(of solids that members explain), all mitres and grooves, and 78 % of the contacts are welds: 99 % on weldments, a fifth
on parts of toys and furniture, which nothing in the file tells apart. What a person marked is a weld, whatever the
findings."""
GAP_SHARE_LOST = 0.4
"""Share of the score that is lost if the mean gap is as wide as allowed; a tee with a gap of 0.4 mm of 0.5 mm is
still accepted."""
SCORES, SHARES = (0.0, 0.25, 0.49, 0.5, 0.95, 1.0), (0.0, 0.05, 0.06, 0.8, 0.95, 1.0)
"""Of the candidates with these scores, such shares are welds (`docs/benchmark.md`); straight lines in between. Three
things are counted: of what a finding refuses, one in 17; of rounds, gaps and short ends, 80 %; of the rest, 95 %."""


@dataclass(frozen=True, slots=True)
class RuleRow:
    """One row of the table."""

    factor: float  #: The score is multiplied by it.
    finding: str  #: What was found.
    why: str  #: Why this speaks against a weld, and why as much.
    evidence: str  #: What the finding rests on.


class Rule(Enum):
    """Every finding that speaks against a candidate, the strongest first."""

    IN_MATERIAL = RuleRow(
        0.01,
        "The wire would be inside another solid. Never accepted.",
        "No torch welds inside material.",
        "shape: tip and wire at every station",
    )
    SAID_NOT = RuleRow(
        0.01, "You said that a solid is not welded (`--not`, `--member`).", "You know the part.", "your word"
    )
    SAID_ONE = RuleRow(0.01, "You said that both sides are one (`--member`).", "You know the part.", "your word")
    SAME_ROOM = RuleRow(
        0.05,
        "A solid fills room that another solid fills.",
        "It is a copy, such as the body before its last chamfer, or lies inside the other one; only one of the two can "
        "be a member.",
        "shape: the same points inside",
    )
    NOT_METAL_WRITTEN = RuleRow(
        0.05,
        "The file says that a solid is of wood, plastic, rubber, glass or the like.",
        "Such a material is not welded to metal.",
        "material of the product in the file",
    )
    FASTENER = RuleRow(
        0.05,
        "A solid is a bolt, a screw, a nut, a washer or a rod with nuts.",
        "It has the shape and the seat of one; it holds others without a weld.",
        "shape: head, nut or ring, and holes for its shank",
    )
    NOT_REACHED = RuleRow(
        0.1,
        "No torch gets there.",
        "Nobody welds what no torch reaches.",
        "shape: rays, and the torch swept along the seam",
    )
    STANDARD_PART = RuleRow(
        0.1,
        "The name has the number of a standard for fasteners, bearings or seals, or a designation such as 6204-2RS.",
        "Nobody gives such a number to a member.",
        "name",
    )
    OTHER_METAL = RuleRow(
        0.15,
        "The materials of the two solids are not welded to each other, such as steel and aluminium.",
        "They form brittle alloys; such joints are brazed, glued or bolted.",
        "materials in the file or in names",
    )
    NOT_METAL_NAMED = RuleRow(
        0.15,
        "The name of a solid says wood, plastic, rubber, glass or the like.",
        "Names seldom lie about material, but may say what a thing is for.",
        "name",
    )
    NOT_METAL_DENSITY = RuleRow(
        0.15,
        "The density of a solid is below 1600 kg/m³, and not 1000.",
        "Metals that are welded are denser. 1000 is what programs write if nobody chose a material.",
        "density of the product in the file",
    )
    ROLLED = RuleRow(
        0.2,
        "Concave edge or round: it is inside one member (rolled profile, bent sheet, outline of a plate).",
        "The root of a rolled profile is not a weld.",
        "shape: the members into which the solid is taken apart",
    )
    CUT = RuleRow(
        0.2,
        "Concave edge or round: it is the corner of a notch, a slot or a coped end.",
        "What cut the wall left it.",
        "shape: it runs across a wall, and no other inner corner meets it",
    )
    SMALLER_THAN_NOZZLE = RuleRow(
        0.3,
        "Both solids are smaller than the nozzle of the torch in all directions, or one is smaller than half of it.",
        "No robot welds a ball bearing or a terminal of 10 mm with an arc. If the unit of the file is wrong, so is "
        "this finding.",
        "size: box of the solid, nozzle of the torch",
    )
    TOO_THIN = RuleRow(
        0.3,
        "A sheet is thinner than 1.2 mm, the wall of a tube than 0.5 mm, or a bar than 6 mm both ways.",
        "An arc burns through sheet that is thinner than its wire, and its pool is as wide as such a bar.",
        "shape: thickness of plane solids, felt through the material; section of members",
    )
    TOO_SHORT = RuleRow(
        0.3,
        "The seam is shorter than `--min-length-mm` (5 mm by default).",
        "It is rather a step in a machined part or a sliver.",
        "length",
    )
    NAMED_PART = RuleRow(
        0.3,
        "The name of a solid says bolt, nut, bearing, motor, linear guide, seal, cable, spring or the like.",
        "A word may say what a member is for; that is why it counts only where the name is about it.",
        "name, in 14 languages",
    )
    HOLE_RIM = RuleRow(
        0.3,
        "The seam runs round inside a hole of at most 40 mm that the other member covers.",
        "It is a bolt hole, or a plug weld, which is filled and not followed.",
        "shape",
    )
    BOLTED = RuleRow(
        0.4,
        "Fasteners, or a pin, go through both members where they touch.",
        "What is bolted is to come apart, or cannot be welded. Only a seam round the clamped faces is meant.",
        "shape: fastener, and holes of both members on its axis that open in the plane of the seam",
    )
    BENT = RuleRow(
        0.4,
        "Concave edge: it is the inner corner of a bent sheet.",
        "A bend is not a joint.",
        "shape: the same thickness on both sides",
    )
    ROLLING = RuleRow(
        0.4,
        "A solid rolls or lies loose: rollers and stock (flare grooves), a wheel on its shaft.",
        "It touches others along lines, as a bar does that is welded along a plate. A wheel turns.",
        "shape: equal round solids between others, a shaft in a bore, or a bore and a round tread",
    )
    NOT_MARKED = RuleRow(
        0.4, "Other edges are marked, and not this one.", "You say what the seams are.", "`--marked`, `--edge`"
    )
    LINED_UP = RuleRow(
        0.45,
        "Two or more holes or slots of both members line up where they touch, one goes on through the far wall of a "
        "tube, or both have knuckles of a hinge in turn.",
        "They are for bolts that are not in the file; pads with holes are welded now and then.",
        "shape: same axis, similar diameter, both open in the plane of the seam",
    )
    NAMED_ABOVE = RuleRow(
        0.45,
        "The name of a group above a solid in the tree of products says one of these things.",
        "A motor holds members as well, but they are not welded here.",
        "name of a product or an instance that does not hold the whole part",
    )
    FIXES_BOLTED = RuleRow(
        0.45,
        "A weld would fix what bolts hold: the solid is bolted to a member that is welded to the other one.",
        "Then the bolts would be of no use. Of the two welds the shorter one is doubted.",
        "seams and bolted faces of the whole part",
    )
    CLOSED_IN = RuleRow(
        0.45,
        "The two solids hold each other: no straight move takes them apart.",
        "They cannot have been put together as they are: a pane in its groove, a cell in its case. A frame that was "
        "fused to one body may hold a panel so.",
        "shape: the normals of all contacts between the two",
    )
    HELD_FAST = RuleRow(
        0.5,
        "A ring sits between two shoulders of the other solid: a tyre on its rim, a seal in its groove.",
        "It cannot have been put there as it is: it was stretched, snapped in, or moulded round. A shaft that was "
        "several members may hold a welded ring so.",
        "shape: solid of revolution, seat of its size, wider or narrower on both sides",
    )
    GASKET = RuleRow(
        0.5,
        "A ring up to 5 mm thick lies flat on the other solid, inside a circle of its bolt holes.",
        "It is a gasket, or the raised face of a flange; a flange is welded to a pipe.",
        "shape: solid of revolution, plane under it, three holes or more at one distance from its axis",
    )
    RING_IN_RING = RuleRow(
        0.5,
        "A ring fills the bore of another ring and ends with it on both sides.",
        "It is a bearing, a bush or a seal, and pressed in. A hub in a disc is wider than the disc.",
        "shape: two turned solids on one axis, of one width",
    )
    TIMBER = RuleRow(
        0.5,
        "The part has no tube and no plate under 9 mm, but solid bars of more than 10 kg per metre as steel, with a "
        "slab on them or closed to frames.",
        "A frame of steel is built of tube and profile; this is a table, a window or a chest of wood. A press or an "
        "anvil may be built so: name the material, or use `--weld`.",
        "shape: thickness and width of every solid, felt through the material",
    )
    BURIED = RuleRow(
        0.5,
        "Most of the line in which the two solids meet is inside a solid; this is the rest of it.",
        "Members are cut to fit each other; such solids were put into each other.",
        "length of all candidates between the two",
    )
    LEFT_OVER = RuleRow(
        0.515,
        "Of the joints that could be welded, four fifths have a solid that was made in one piece; this is one of the "
        "rest.",
        "In an assembly of castings or mouldings, bars and plates are rather screwed on, too.",
        "length of all joints of the part",
    )
    ONE_PIECE = RuleRow(
        0.515,
        "A solid is neither turned, nor explained by members: it looks cast, moulded, printed or milled in one piece.",
        "Members of a weldment are cut from plate, bar and tube. Such a solid is rather bolted or clamped; a milled "
        "clevis is welded now and then, so `--generous` takes it, also between two of them.",
        "shape: the members into which the solid is taken apart",
    )
    SHORT_END = RuleRow(
        0.525,
        "The run goes across the end of a plate, beside a long seam along it.",
        "Nobody strikes an arc only for that: the end is a wrap of the long seam (`--wrap`), or stays open.",
        "shape: the plate behind the long seam is as thick as the run is long",
    )
    PIN_IN_HOLE = RuleRow(
        0.8,
        "A round member is in a hole of the same size, and is not a tube that is longer than it is wide.",
        "It may be pressed in, or turn there.",
        "shape",
    )
    GAP = RuleRow(
        1.0 - GAP_SHARE_LOST,
        "There is a gap, and it is not the play of the assembly. The factor is for the largest allowed gap; a smaller "
        "gap lowers the score less.",
        "Members that are meant to be joined touch.",
        "mean gap along the seam",
    )

    @property
    def factor(self) -> float:
        """The score is multiplied by it."""
        return self.value.factor

    @property
    def key(self) -> str:
        """Name of the rule in records: ``not-reached``."""
        return self.name.lower().replace("_", "-")

    def found(self, text: str, factor: float | None = None, *, solid: str = "") -> Finding:
        """Return a finding by this rule, in words; `solid` is the name of the solid that it is about."""
        return Finding(self.key, self.factor if factor is None else factor, text, solid)


def confidence_of(source: SeamSource, findings: Iterable[Finding]) -> float:
    """Return how sure it is that a candidate is a weld, from 0 to 1: it never rises with a finding."""
    return float(np.interp(score_of(source, findings), SCORES, SHARES))


def score_of(source: SeamSource, findings: Iterable[Finding]) -> float:
    """Return the number by which candidates are ranked, from 0 to 1."""
    return PRIOR[source] * math.prod(finding.factor for finding in findings)
