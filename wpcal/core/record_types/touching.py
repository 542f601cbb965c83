"""Records: advice, moved-advice, touches."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    D,
    FeatureOfPart,
    Maybe,
    NotNegative,
    Number,
    Place,
    Positive,
    Record,
    Rotation,
    Units,
    Vector,
)
from wpcal.core.record_types.robots import Arm


class Set(Record):
    features: list[str] = D("Names of the features.")
    error_95_mm: NotNegative = D("Largest error along the seams that is not exceeded with 95 % probability.")
    seam: str = D("The seam with this error.")
    swap_rms_mm: NotNegative = D("Smallest root mean square residual if two or more names are exchanged by mistake.")
    swap: list[str] = D("The names in that exchange.")
    swap_is_seen: bool = D("Whether that residual is larger than the teaching error can cause.")


class Feature(FeatureOfPart):
    where: str = D("In words: where on the part it is.")


class ByCount(Set):
    points: Number = D("Number of points.")


class Advice(Record):
    """wpcal advice, version 1

    Which features to teach (wpcal advise --json). Points in part, lengths in mm.
    """

    schema: Literal["wpcal/advice/1"]
    sigma_mm: Positive = D("Assumed teaching error: standard deviation per axis.")
    criterion: Literal["minimax", "least_squares", "weighted", "robust"]
    chosen: Set
    points: list[Feature] = D("The chosen features.")
    by_count: list[ByCount] = D("The best set for each number of points.")
    next_point: str | None = D("The best feature to add; null if there is none.")
    with_next: Set | None = D("The chosen set with next_point.")
    notes: list[str] = D("Sentences about the choice.")


class Touch(Record):
    name: str
    where: str = D("The touch in words.")
    body: str = D("The body that the touch lies on.")
    seam: str = D("The seam that the touch serves: the worst one of this body before the touch.")
    before_mm: NotNegative | None = D(
        "Largest 95 % error of this seam before the touch; null while the touches leave the part free."
    )
    after_mm: NotNegative | None = D("The same after the touch.")
    sentence: str


class BySeam(Record):
    seam: str
    error_95_mm: NotNegative


class Body(Record):
    name: str
    tack_mm: Positive
    tack_mrad: Positive


class MovedAdvice(Record):
    """wpcal advice for bodies that may move, version 1

    What to touch on a weldment whose bodies may have moved (wpcal advise --bodies --json). Lengths in mm.
    """

    schema: Literal["wpcal/moved-advice/1"]
    touches: list[Touch] = D("In the order in which each lowers the errors most.")
    error_95_mm: NotNegative = D("Largest predicted 95 % error of a seam point after all touches.")
    seam: str = D("The seam where it occurs.")
    unseen_mm: NotNegative = D("The part of it that comes from motions of bodies which no touch sees.")
    joint_95_mm: NotNegative = D(
        "What no point of the seams exceeds, with 95 % probability: wpcal calibrate compares this with its tolerance."
    )
    by_seam: list[BySeam]
    next: Touch | None = D("The best further touch; null if there is none.")
    bodies: list[Body]
    tolerance_mm: Positive | None = D("What was asked for; null if nothing was.")
    why_not: str = D("Why the tolerance is not reached; empty if it is.")


class Predicted(Record):
    error_95_mm: NotNegative = D("Largest predicted 95 % error along the seams.")
    seam: str = D("The seam where it occurs.")
    by_seam: list[BySeam]
    joint_95_mm: Maybe[NotNegative | None] = D(
        "What no point of the seams exceeds, with 95 % probability: wpcal calibrate compares it with its tolerance."
    )
    unseen_mm: Maybe[NotNegative] = D("The part of error_95_mm that comes from motions of bodies which no touch sees.")
    why_not: Maybe[str] = D("Why a tolerance that was asked for is not reached; otherwise empty.")


class Serves(Record):
    seam: str
    before_mm: NotNegative | None
    after_mm: NotNegative | None


class Search(Record):
    name: Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9]{0,7}$")] = D("Unique in the plan.")
    kind: Literal["part", "post"] = D("part: a touch on the part; post: on a post that does not move with it.")
    target: str = D("What is touched, in the words of a taught table's column kind.")
    feature: str = D("Name of the touched feature, or empty.")
    contact: Literal["side", "end"] = D("What of the torch meets the face: the side or the end of the wire.")
    contact_mm: Vector = D("The point that is touched where the part stands as planned.")
    normal: Vector = D("Outward unit normal there.")
    radius_mm: NotNegative = D("Distance of the tip of the wire from the face at contact, along the normal.")
    R_part_tool: Rotation = D("Axes of the tool as columns; z leaves the wire tip.")
    via_mm: list[Annotated[Vector, D("A place of the tip of the wire.")]] = D(
        "Points on the way from the search before (or from home) to the approach."
    )
    approach_mm: Vector = D("The robot goes there in the air.")
    start_mm: Vector = D("Where the search begins.")
    end_mm: Vector = D("Where the search ends without contact.")
    retract_mm: Vector = D("The robot leaves to here by way of the start.")
    covariance_mm2: Rotation = D("Of the tool centre point that the controller stores.")
    joints_deg: list[list[float]] | None = D("Shown angles at approach, start and end; null without an arm.")
    via_joints_deg: list[list[float]] | None = D("Shown angles at the points on the way; null without an arm.")
    body: Maybe[str] = D("The body that is touched, if bodies may move; otherwise empty.")
    serves: Maybe[Serves | None] = D("What the search does for a seam, if bodies may move.")
    axis: Maybe[Annotated[list[Vector], Meta(min_length=2, max_length=2)] | None] = D(
        "A point of the axis of a cylinder, mm, and its direction; null for others."
    )


class FirstStage(Record):
    centre_mm: Vector = D("The point of the part about which it is turned.")
    covariance: Annotated[
        list[Annotated[list[float], Meta(min_length=6, max_length=6)]], Meta(min_length=6, max_length=6)
    ] = D("Of its turn (rad) and of the motion of this point (mm) after the searches.")


class Touches(Record):
    """A plan of touches: searches in the order in which the robot makes them (touches.json)"""

    schema: Literal["wpcal/touches/1"]
    units: Units
    part: str = D("File name of the STEP file.")
    fingerprint: Annotated[str, Meta(pattern="^[0-9a-f]{8}$")] = D(
        "Of what the program depends on; computed from the searches."
    )
    T_base_part: Place = D("Where the part stands as planned: the work object. All points are in it.")
    wire_mm: NotNegative = D("Diameter of the wire.")
    stick_out_mm: NotNegative = D("From the contact tip to the tip of the wire.")
    standoff_mm: Maybe[NotNegative] = D("From the tool centre point of the controller to the tip; 0 if not given.")
    robot: str = D("Name of the arm; empty if none is given.")
    arm: Maybe[Arm | None] = D("The arm, with which programs state the configuration; null if none is given.")
    home_joints_deg: list[float] | None = D(
        "Shown angles before the first and after the last search; null without an arm."
    )
    predicted: Predicted | None = D("Predicted errors of the seams; null if the part has none.")
    notes: list[str] = D("What a person should know of the plan.")
    searches: list[Search] = D(
        "In the order in which they run. All points are places of the tip of the wire in the work object."
    )
    first_stage: Maybe[FirstStage] = D(
        "What is known of the place after these searches, which do not hold the part: wpcal touches --after plans more."
    )
    bodies: Maybe[list[Body]] = D("Bodies that may move, with the assumed tack tolerances; empty if the part is one.")
