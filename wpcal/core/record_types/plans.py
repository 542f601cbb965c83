"""Records: plan, pareto, weld-sequence."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.cells import Issue
from wpcal.core.record_types.parts import Count, D, Maybe, NotNegative, Number, Pair, Place, Positive, Record, Six

AT_LIMIT = D("The joint that reaches its speed limit first; null if no arm states joint speeds.")
TIP = D("The tip of the wire in the part between the points of the weld, where both controllers interpolate joints.")


class Units(Record):
    length: Literal["mm"]
    angle: Literal["deg"]
    time: Literal["s"]


class SpeedLimit(Record):
    robot: Literal[1, 2]
    joint: str
    s_mm: float
    fastest_mm_s: Positive


class Check(Record):
    method: str
    steps_cut_into: Number
    states: Number
    least_distance_mm: float | None
    least_margin_mm: float | None = D("Distance minus the safety distance of the pair.")
    between: Annotated[list[str], Meta(min_length=2, max_length=2)] | None
    s_mm: float
    largest_motion_between_states_mm: NotNegative
    largest_tip_error_mm: NotNegative


class BetweenPoints(Record):
    largest_tip_error_mm: NotNegative = D("Largest distance from the line between neighbouring points.")
    s_mm: float = D("Place of that distance along the seam.")
    slowest_mm_s: NotNegative = D("Least speed of the tip in the part; speed_mm_s is asked.")
    fastest_mm_s: NotNegative


class Robot(Record):
    arm: str
    joints: Annotated[list[str], Meta(min_length=6, max_length=6)]


class Coordinated(Record):
    language: str = D("Name of the format.")
    holder_moves: Literal["joints", "line"] = D("How robot 2 moves from mark to mark.")
    lines: Count
    arcs: Count
    s_mm: Annotated[list[float], Meta(min_length=2)] = D("Lengths along the seam at the marks.")
    wire_off_mm: NotNegative = D("Largest distance of the wire's tip from the seam, in the part.")
    wire_off_deg: NotNegative = D("Largest angle of the wire from that of the plan, in the part.")
    part_turned_deg: NotNegative = D("Largest difference of the part's attitude from the plan.")
    part_off_mm: NotNegative = D("Largest distance of the weld point in space from the plan.")
    freedom: Literal["unchecked", "free", "not free"]
    check: Check = D("Measurements of these moves.")


class Point(Record):
    mark: Number = D("Number of the sync mark in the programs.")
    phase: Literal["approach", "weld", "retract"] = D("What happens on the way to this state.")
    t_s: NotNegative
    robot1_deg: Six = D("Angles as the controller shows them, deg.")
    robot2_deg: Six = D("Angles as the controller shows them, deg.")
    s_mm: float | None = D("Arc length; null in the air, like the four angles.")
    slope_deg: float | None
    rotation_deg: float | None = D("Also null in vertical travel.")
    work_deg: float | None
    travel_deg: float | None
    clearance_mm: float | None = D("Distance of the pair with the least margin.")


class Plan(Record):
    """One planned weld of two robots: the joints of both with times"""

    schema: Literal["wpcal/plan/1"]
    cell: str
    seam: str
    found_by: str = D("Method: ladder or nsga2.")
    units: Units
    objectives: dict[str, float] = D("Values of the minimised objectives, by name.")
    as_printed: dict[str, float] = D("The functions of Hou 2018 as printed.")
    speed_mm_s: Positive = D("Speed of the wire along the seam.")
    asked_mm_s: Positive
    speed_limit: SpeedLimit | None = AT_LIMIT
    freedom: Literal["unchecked", "free", "not free"]
    check: Check | None = D("Measurements between the points; null if the check did not run.")
    between_points: Maybe[BetweenPoints] = TIP
    issues: Maybe[list[Issue]] = D("What is odd in the cell: bodies, frames and mounting faces (wpcal plan --check).")
    robots: Annotated[list[Robot], Meta(min_length=2, max_length=2)]
    coordinated: Maybe[list[Coordinated]] = D(
        "The coordinated motion in the programs of each language. Empty for programs of joint moves."
    )
    points: Annotated[list[Point], Meta(min_length=2)]
    weld_s: NotNegative = D("Time of the weld from its first point to its last, s.")
    made_from: Maybe[dict[str, str]] = D("SHA-256 of the files in input, from which the plan was made.")
    digest: Maybe[str] = D("SHA-256 of all else in this record.")


class Obstacle(Record):
    constraint: Literal[
        "reach",
        "joint limits",
        "singular poses",
        "clearance",
        "torch angles",
        "weld position",
        "weld zone",
        "joint speeds",
    ]
    says: str = D("What was found, where, and what was asked.")
    advice: str = D("What would help; may be empty.")
    s_mm: float | None = D("Place along the seam.")
    between: Annotated[list[str], Meta(min_length=2, max_length=2)] | None = D("Two bodies that are too near.")
    robot: Literal[1, 2] | None
    joint: str | None
    best: float | None = D("Best value attained at this place, in unit.")
    asked: float | None = D("Value that is asked, in unit.")
    unit: Literal["mm", "deg", "mm/s", ""]


class Front(Record):
    hypervolume: float
    values: list[list[float]]


class ParetoPlan(Record):
    plan: Number = D("Its number, from 1.")
    found_by: Literal["ladder", "nsga2"]
    freedom: Literal["unchecked", "free", "not free"] = D("What the check between the points found.")
    objectives: dict[str, float] = D("Values of the minimised objectives, by name.")
    as_printed: dict[str, float] = D("f1_1, f1_2 and f2 of Hou 2018 as printed.")
    least_clearance_mm: float | None = D(
        "Distance between the hulls of the pair of bodies that is nearest to its safety distance, mm."
    )
    s_mm: list[float]
    robot1_deg: list[Six]
    robot2_deg: list[Six]
    slope_deg: list[float]
    rotation_deg: list[float]
    work_deg: list[float]
    travel_deg: list[float]
    between_points: Maybe[BetweenPoints] = TIP


class Run(Record):
    speed_mm_s: Positive = D("Speed of the wire along the seam.")
    asked_mm_s: Positive
    weld_s: NotNegative = D("Time of the weld from its first point to its last, s.")
    speed_limit: SpeedLimit | None = AT_LIMIT
    freedom: Literal["unchecked", "free", "not free"]
    check: Check | None = D("Measurements between the points; null if the check did not run.")
    between_points: BetweenPoints = TIP


class ParetoUnits(Record):
    length: Literal["mm"]
    angle: Literal["deg"]


class Pareto(Record):
    """wpcal Pareto set, version 1

    Trade-off plans of a seam to choose from (pareto.json).
    """

    schema: Literal["wpcal/pareto/1"]
    cell: str
    seam: str
    units: ParetoUnits
    speed_mm_s: Positive
    safety_distance_mm: float
    wishes: dict[str, float]
    objectives: list[str] = D("Names, in the order of the columns of the fronts.")
    failed: str | None = D("Why there is no plan; null if there is one.")
    obstacle: Maybe[Obstacle | None] = D(
        "The limit that is hardest to keep, and where; null if there is a plan or no limit can be named."
    )
    issues: Maybe[list[Issue]] = D("What is odd in the cell: bodies, frames and mounting faces (wpcal plan --check).")
    interrupted: Maybe[bool]
    not_free: Maybe[Count] = D("Plans left out by the check between their points.")
    preference: Maybe[Literal["position", "smooth", "balanced"]]
    chosen: Maybe[Number] = D("Number of the plan of that preference.")
    reference: Maybe[list[float]] = D("Corner of the hypervolumes.")
    hypervolume: Maybe[float]
    fronts: Maybe[dict[str, Front]] = D("Front that each method found alone: ladder, nsga2.")
    plans: list[ParetoPlan]
    run: Maybe[Run] = D("The chosen plan with approach and retract: speed, collisions, and the tip between the points.")
    no_program: Maybe[list[str]] = D("Why a robot has no program.")


class WeldSequencePlan(Record):
    position_deg: float
    torch_deg: float
    motion_deg_per_mm: float
    time_s: float


class Seam(Record):
    name: str = D("The seam's, with a letter where it is welded in pieces.")
    seam: str
    from_mm: float
    to_mm: float
    is_reversed: bool = D("Welded against the direction of the seam file, from to_mm to from_mm.")
    external: list[float] = D("External axes at the start.")
    external_end: list[float] = D("External axes at the end: they change evenly along the piece.")
    branch: int = D("0 to 7: 4 for the shoulder turned back, 2 for the other elbow, 1 for the flipped wrist.")
    slope_deg: float = D("In the middle of the piece, positive uphill.")
    rotation_deg: float | None = D("In the middle of the piece; null in vertical travel.")
    off_position_deg: float = D("Largest distance from the asked weld position.")
    in_position: bool
    off_torch_deg: float
    speed_mm_s: float
    slowed_by: str | None = D("The axis that does not allow the asked speed.")
    least_margin_mm: float = D("Least distance of any two bodies, less their safety distance, a lower bound.")


class Help(Record):
    text: str
    turn_deg: float
    move_mm: Pair
    raise_mm: float = D("Of the part, with its positioner.")
    from_table_mm: float = D("Of the part, away from the table of its positioner.")
    torch_range_deg: float | None = D("How far the torch may leave its target angles.")
    torch_scale: float | None = D("Radius of another torch's bodies relative to those of this one.")


class Unwelded(Record):
    seam: str
    from_mm: float
    to_mm: float
    why: str
    help: list[Help] = D("Changes with which the stretch has a way, as a trial with collisions showed.")
    is_searched: bool = D("Whether all kinds of changes were tried.")


class WeldSequencePoint(Record):
    t_s: float
    phase: Literal["air", "approach", "weld", "retract"]
    seam: str | None
    s_mm: float | None = D("Along the seam of the file; null off the weld.")
    axes: list[float]
    margin_mm: float | None = D("Least margin from here to the next point, a lower bound; null if nothing can meet.")


class Runs(Record):
    tacks: Literal["first", "only", "off"]
    weave: Literal["controller", "points"]
    overlap_mm: float = D("By which closed seams are welded on over their start.")


class KeptPiece(Record):
    before: int = D("States of the approach: the first ones.")
    after: int = D("States of the retract: the last ones.")
    states: list[list[float]] = D("Axes at the points of approach, weld and retract.")


class KeptWay(Record):
    from_home: list[list[float]] = D("Axes from home to the first state of the piece; empty if no free way was found.")
    to_home: list[list[float]] = D("Axes from its last state to home.")


class KeptPlan(Record):
    """What programs are written from"""

    speed_mm_s: float = D("Of the wire, where weld data do not say it.")
    approach_mm: float
    air_speed_mm_s: float
    pieces: list[KeptPiece] = D("As in seams.")
    air: list[list[list[float]]] = D("Axes of the moves from home to the first piece, between pieces, and home.")
    ways: list[KeptWay] = D("Per piece, for a piece that is welded by itself: each way is proved free as those of air.")


class WeldSequence(Record):
    """One robot welds all seams: pieces in their order, what is left out, and all axes with times"""

    schema: Literal["wpcal/weld-sequence/1"]
    cell: str
    units: Units
    freedom: Literal["free", "not free"] = D("Whether every move is proved free of collision: free or not free.")
    checked: str = D("What was compared with what.")
    open: Maybe[list[str]] = D("What was not checked, not welded, off position or without a way; one line each.")
    axes: list[str] = D("Six joints of the arm, the rail if there is one (mm), the axes of the positioner.")
    welded_mm: float = D("Length of all pieces.")
    time_s: float
    position: Literal["flat", "PA", "PB", "any"] = D("The asked weld position.")
    position_tol_deg: float
    chosen: Literal["position", "smooth", "balanced"] = D("The plan that is worked out.")
    plans: dict[str, WeldSequencePlan] = D(
        "Values of all plans, by preference; the times of those that are not worked out assume straight moves."
    )
    T_carrier_part: Place = D("The part on the positioner's flange, or in world.")
    seams: list[Seam] = D("Pieces in the order of welding.")
    unwelded: list[Unwelded] = D("Stretches that are not welded.")
    no_program: dict[str, str] = D("Why there is no program, by the language.")
    made_from: Maybe[dict[str, str]] = D("SHA-256 of the files in the folder input, by name.")
    planned: Maybe[list[str]] = D("The seams that were asked for.")
    runs: Maybe[Runs] = D("Which runs the weld data became.")
    kept: Maybe[KeptPlan]
    points: list[WeldSequencePoint]
    digest: Maybe[str] = D("SHA-256 of the record without this field.")
