"""Records: seams, truth."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    D,
    Issue,
    Matrix,
    MatrixByRows,
    Maybe,
    Member,
    NotNegative,
    Number,
    Open,
    Positive,
    Quaternion,
    Record,
    Rotation,
    Share,
    Space,
    TorchShape,
    Units,
    Vector,
)

STRETCH = D("The stretch to weld: from and to, as arc lengths from the start of the candidate, mm.")


class Torch(TorchShape):
    pass


class SaidMember(Record, rename={"is_": "is"}):
    member: str = D("Name of a solid, or of a member of one: frame/2.")
    is_: str = D("plate, bar, tube, profile, piece, cast, weldment, or the name of another member.")
    at_part_mm: Vector | None = D("The middle of the box around it when that was said, in part, mm.")


class Judging(Record, rename={"not_": "not"}):
    weld: list[str] = D("Names of solids that can be welded (--weld).")
    not_: list[str] = D("Names of solids that are not welded (--not).")
    members: Maybe[list[SaidMember]] = D("What members are said to be (--member).")
    level: Literal["strict", "usual", "generous"]
    least_confidence: Share = D("A candidate with at least this confidence is accepted.")


class Play(Record):
    gap_mm: NotNegative = D("Median of these gaps.")
    joints: Number


class Finding(Record):
    rule: str = D("Key of the rule: not-reached. Empty in files from before rules had keys.")
    factor: Share = D("The score was multiplied by it.")


class Hiding(Open):
    solid: str = D("Name of the solid.")
    length_mm: Positive = D("This much of the stretch would be free.")
    is_loose: bool = D("Whether the solid touches no other one: a fixture, or a part that is mounted later.")


class OtherTorch(Record):
    name: str
    wire_mm: Positive


class Groove(Record):
    depth_mm: NotNegative
    opening_mm: NotNegative
    root_mm: NotNegative


class GapMm(Record):
    min: float
    mean: float
    max: float


class Candidate(Record):
    name: str = D("Name as found: W1, W2, …")
    start_part_mm: Vector
    middle_part_mm: Vector = D("At half the length.")
    length_mm: NotNegative


class Join(Record):
    candidate: Candidate
    range_mm: Maybe[Annotated[list[NotNegative], Meta(min_length=2, max_length=2)]] = STRETCH


class Edit(Record):
    accept: Maybe[bool] = D("Weld it, whatever the rules say.")
    reject: Maybe[bool] = D("Do not weld it.")
    reverse: Maybe[bool] = D("Weld it in the other direction.")
    name: Maybe[Annotated[str, Meta(min_length=1, max_length=200)]]
    range_mm: Maybe[Annotated[list[NotNegative], Meta(min_length=2, max_length=2)]] = STRETCH
    other_side: Maybe[bool] = D("The torch comes from the other side: y and z are reversed.")
    join: Maybe[list[Join]] = D(
        "Other candidates, or stretches of them, that are welded with it in one run. Their ends meet; they are no "
        "seams of their own."
    )


class LeanDeg(Record):
    work: Annotated[float, Meta(ge=-60, le=60)]
    travel: Annotated[float, Meta(ge=-60, le=60)]
    spin: Maybe[Annotated[float, Meta(ge=-180, le=180)]]


class Frame(Record):
    s_mm: NotNegative = D("Arc length from the start of the seam, mm.")
    p_mm: Vector = D("Origin, mm.")
    R: Rotation = D("Rows of the rotation; its columns are the axes x (travel), y, z (out of the joint) in `frame`.")
    q_xyzw: Quaternion = D("The same rotation as a unit quaternion, w >= 0.")
    angle_deg: Annotated[float, Meta(ge=0, le=180)] = D("Angle between the outward normals of the two faces.")
    lean_deg: Maybe[LeanDeg | None] = D(
        "Work and travel angle (positive is push) with which the torch meets nothing; 0 and 0 is straight along z. "
        "spin is how far a bent neck is turned about the wire, right-handed from its tip; at 0 it bends against the "
        "travel. null: the torch always meets something. Missing: the frames were made without a part, by a script or "
        "an older version."
    )
    u95_mm: Maybe[NotNegative] = D("Error of the position that is not exceeded with 95 % probability, mm.")
    slope_deg: Maybe[float] = D("Slope of the weld axis, positive uphill; gravity is along -z of the base.")
    rotation_deg: Maybe[float | None] = D("Rotation of the weld; null in vertical travel.")
    position: Maybe[str | None] = D("Weld position by its ISO name, for example PA.")
    u95_across_mm: Maybe[NotNegative] = D(
        "The 95 % error across the seam, mm: what lies along the seam moves its ends only. Only with --bodies."
    )
    u95_placing_mm: Maybe[NotNegative] = D(
        "The part of the 95 % error that the errors of the touches leave, mm. Only with --bodies."
    )
    u95_unseen_mm: Maybe[NotNegative] = D(
        "The part of the 95 % error that motions of the bodies leave which no touch saw, mm. Only with --bodies."
    )
    gap_mm: Maybe[float] = D(
        "Gap between the edge of one body and the face of the other after they moved, mm; negative: they overlap. Only "
        "with --bodies."
    )


class Seam(Record):
    name: str
    joint: Literal["tee", "lap", "butt", "corner", "edge", "unknown"]
    weld: Literal["fillet", "groove", "flare-bevel groove", "flare-V groove", "unknown"]
    solids: list[str]
    closed: bool
    length_mm: NotNegative
    accepted: bool = D("Taken as a weld unless the user says otherwise.")
    confidence: Maybe[Share] = D("How sure the rules are that this is a weld; accepted from 0.8.")
    reachable: bool
    source: Maybe[str] = D("Where the candidate comes from.")
    reasons: list[str]
    against: Maybe[list[str]] = D("What speaks against it, the strongest first.")
    findings: Maybe[list[Finding]] = D("The rule behind each entry of `against`, in the same order.")
    inside: Maybe[list[str]] = D(
        "Solids in whose material the tip or the wire would be along the whole seam; it is then never accepted."
    )
    blocked_by: Maybe[list[str]] = D("Solids that the torch meets along the whole seam with every lean that was tried.")
    hiding: Maybe[list[Hiding]] = D(
        "What the torch would reach of this stretch without one of the solids of blocked_by that it does not join. "
        "Missing: nothing is gained, or it was not asked (only the longest stretches are)."
    )
    wrap_of: Maybe[str] = D(
        "Name of the seam of which this one is a wrap: it goes across the end of a plate beside that seam, and is "
        "welded with it or left open. Absent for other seams."
    )
    more_wire_mm: Maybe[Annotated[float, Meta(gt=0, le=100)]] = D(
        "How much longer than torch.wire_mm the wire must be for this seam: the torch stays back by it. Missing: 0."
    )
    other_torch: Maybe[OtherTorch] = D(
        "The most usual shipped torch that reaches all of this stretch, which the torch of this file does not reach, "
        "and the wire that it needs. Missing: none does, or the stretch is reached."
    )
    bead_mm: Maybe[Annotated[float, Meta(gt=0, le=100)]] = D(
        "Throat of the bead or round that is drawn in the corner, in the middle of the seam, mm."
    )
    groove: Maybe[Groove] = D(
        "Cross-section of a flare groove in the middle of its seam: from the root to the mouth, the width of the "
        "mouth, and from the root to the seam."
    )
    gap_mm: GapMm
    candidate: Maybe[Candidate] = D(
        "The candidate of the part behind this seam, identified by its place. An edit refers to this candidate."
    )
    edit: Maybe[Edit] = D("Decisions of a person. Pass the edited file with --seams.")
    frames: list[Frame]


class Section(Record):
    wall_thickness_mm: float | None
    base_thickness_mm: float | None
    gap_mm: float = D("On average along the seam.")
    opening_deg: float = D("Angle between the two faces, on the side of the torch.")
    largest_throat_mm: float | None = D("Of a fillet: 0.7 of the thinner member.")


class ExplainedFinding(Record):
    rule: str
    factor: Share
    text: str
    why: str
    found_by: str
    confidence_after: Share


class Explained(Record):
    seam: str
    accepted: bool
    confidence: Share
    least_confidence: Share
    start_confidence: Share = D("By its source, before any finding.")
    start_score: Share = D("The score by its source; times all factors it is `score`.")
    score: Share = D("The number by which candidates are ranked; `confidence` is how often those of a score are welds.")
    section: Maybe[Section] = D("The joint across the middle of the seam; lengths mm.")
    chain: list[str] = D("The decisions in words, in their order.")
    findings: list[ExplainedFinding]
    members: list[Member]
    picture: str = D("The SVG file.")


class Seams(Record):
    """wpcal seams, version 1

    Weld seams as pose frames (seams.json).
    """

    schema: Literal["wpcal/seams/1"]
    frame: Literal["base", "part"] = D("Frame of all positions and rotations.")
    units: Units
    z_sense: Literal["outward"] = D("z points out of the joint.")
    robot_space: Space
    torch: Maybe[Torch] = D(
        "The torch with which reach was felt. Without a neck, one radius goes on from the nozzle to the end."
    )
    T_base_part: Matrix | None = D(
        "Carries points from the STEP file's coordinates (part) to base; 4×4, mm. Null if the frames are in part."
    )
    judging: Maybe[Judging] = D("What a person said about members, and how sure a seam had to be.")
    play: Maybe[list[Play]] = D(
        "Gaps that several joints of the part have: the clearance with which it was designed, the most frequent first. "
        "Empty if --gap-mm was given."
    )
    join_mm: Maybe[NotNegative] = D("A decision may join seams whose ends are at most this far from each other, mm.")
    members: Maybe[list[Member]] = D("What each solid of the part is taken for.")
    issues: Maybe[list[Issue]] = D("What is odd in the part's file (wpcal seams --json).")
    seams: list[Seam]
    explained: Maybe[Explained] = D("What decided about one seam (wpcal seams --explain --json).")


class Body(Record):
    name: str
    centre_part_mm: Vector = D("The point about which the body turned, in part.")
    moved_mm: Vector = D("Motion of this point, in part.")
    turned_mrad: Vector = D("Rotation vector, in part.")


class TruthSeam(Record):
    solids: list[str]
    ends_base_mm: Annotated[list[Vector], Meta(min_length=2, max_length=2)] = D("Both ends, in base.")


class Truth(Record):
    """wpcal truth of a sample, version 1

    The true pose of a sample part and the errors of its taught points (truth.json of wpcal demo).
    """

    schema: Literal["wpcal/truth/1"]
    about: str = D("The part in words.")
    T_base_part: MatrixByRows = D("True pose: carries points from part to base.")
    teaching_sigma_mm: NotNegative = D("Standard deviation per axis of the errors in taught.csv.")
    teaching_seed: int
    teaching_rounded_to_mm: NotNegative = D("Step to which the numbers in taught.csv are rounded.")
    bodies: Maybe[list[Body]] = D("True motions of the bodies of a weldment whose plates moved (fixtures/uprights).")
    seams: Maybe[list[TruthSeam]] = D("Straight lines in which the moved bodies really meet.")
