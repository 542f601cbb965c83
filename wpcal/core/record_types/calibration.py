"""Records: calibration."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    Count,
    Covariance,
    D,
    Issue,
    Matrix,
    MatrixByRows,
    Maybe,
    NotNegative,
    Number,
    Positive,
    Record,
    Rotation,
    Sha256,
    Share,
    Space,
    ToolError,
    Vector,
)


class Taught(Record):
    file: str = D("Name of the file, without folder.")
    sha256: Annotated[Sha256, D("SHA-256 of the file's bytes, hexadecimal.")] | None


class Bodies(Record):
    file: str = D("Name of the file, without folder.")
    sha256: Sha256 = D("SHA-256 of the file's bytes, hexadecimal.")


class Part(Taught):
    unit: str = D("Length unit of the STEP file; all numbers here are in mm.")


class Inputs(Record):
    taught: Taught
    bodies: Maybe[Bodies] = D("The file of --bodies.")
    part: Maybe[Part]


class Plan(Record):
    file: str = D("Name of the file, without folder.")
    fingerprint: str


class LeftOut(Record):
    name: str
    outcome: Literal["missed", "not run", "active at start"]


class Searches(Record):
    plan: Plan
    controller: str = D("Name of the format of the results.")
    tool: str = D("Name or number of the tool of the program, or empty.")
    used: list[str] = D("Searches whose places were fitted.")
    left_out: list[LeftOut] = D("Searches that found nothing.")
    stick_out_error_mm: float | None = D(
        "How much longer than planned the wire is, from touches on a post; null without one."
    )
    latency_mm: float = D("Latency x speed of the touch setup, by which the places were moved back.")


class Judgement(Record):
    kind: Literal["PASS", "UNSURE", "FAIL"] = D("The same as verdict.")
    sentence: str = D("For a person.")
    seam: str | None = D("Accepted seam with the largest predicted error; null if no seam was given.")
    reason: Literal[
        "within",
        "error",
        "unchecked",
        "large-residuals",
        "check",
        "contradiction",
        "stated-error",
        "check-contradicts",
        "rival",
        "silent-search",
        "scale",
        "beyond",
    ] = D(
        "within: shown. error: the predicted error is larger than the tolerance. unchecked: a wrong touch would leave "
        "no residual. large-residuals: no teaching error is stated, and the usual one does not explain the residuals. "
        "check: a check point is off by more than the tolerance, which its own error may explain. contradiction: "
        "observations contradict the others. stated-error: the residuals contradict the stated teaching error. "
        "check-contradicts: a check point is off by more than all errors explain. rival: the touches do not exclude "
        "another place of the part. scale: the part is larger or smaller than its model. beyond: a seam is outside "
        "with 95 % confidence."
    )
    error_95_mm: NotNegative = D(
        "With 95 % probability no point of the accepted seams is off by more. Without seams: no fitted point."
    )
    next_point: str | None = D("The first of next_points; null if none is known.")
    next_points: Maybe[list[str]] = D(
        "Features to touch next: the fewest that are predicted to bring the error within the tolerance, at most 4."
    )


class SixTuple(Record):
    x_mm: float
    y_mm: float
    z_mm: float
    alpha_rad: float
    beta_rad: float
    gamma_rad: float


class Correction(Record):
    T_base_nominal: MatrixByRows = D("Correction of the cell's model, in base.")
    T_nominal_part: MatrixByRows = D("Where the cell's model has the part; identity if not given.")
    six_tuple: SixTuple = D("T_base_nominal as translation and angles, R = Rz(gamma) Ry(beta) Rx(alpha).")


class Point(Record):
    name: str
    use: Literal["yes", "check"] = D("check: not fitted, but counted in the verdict.")
    p_part_mm: Annotated[Vector, D("x, y, z in mm.")] = D("Model point in part.")
    p_base_mm: Annotated[Vector, D("x, y, z in mm.")] = D("Touched point in base.")
    residual_mm: Annotated[Vector, D("x, y, z in mm.")] = D("Touched point minus moved model point, in base.")
    rx_ry_rz_deg: Maybe[Vector] = D("How the tool was turned in base, R = Rz Ry Rx, if the row says.")
    distance_mm: NotNegative = D("Length of the residual.")
    error_95_mm: NotNegative = D("Error at this point that is not exceeded with 95 % probability.")


class CalibrationCovariance(Record):
    order: Annotated[list[str], Meta(min_length=6, max_length=6)] = D(
        "Rows and columns of values: rotation, then translation."
    )
    about: str = D("The point about which the rotation is taken.")
    degrees_of_freedom: NotNegative | None = D("Behind the covariance's scale; null if the teaching error is stated.")
    values: Covariance = D("Row by row: rad², rad·mm and mm².")


class TeachingError(Record):
    sigma_mm: NotNegative | None = D("Standard deviation per axis; null if not stated.")
    bound_mm: NotNegative | None = D("Greatest error per axis; null if not stated.")
    tcp_bias_mm: NotNegative = D("Error of the tool centre point.")
    tool: Maybe[ToolError] = D("Standard deviations of the tool centre point, if stated.")
    used_sigma_mm: Maybe[NotNegative] = D(
        "Standard deviation per axis behind the predicted errors; the root mean square if every touch states its own."
    )
    provenance: Maybe[Literal["stated", "estimated", "assumed"]] = D(
        "stated by the user; estimated from the residuals; assumed, because the residuals show too little."
    )
    degrees_of_freedom: Maybe[Annotated[float, Meta(ge=1)] | None] = D("Behind an estimate; null otherwise.")


class Scale(Record):
    scale: float = D("Relative: 5e-4 is 0.5 mm per metre.")
    error_95: NotNegative = D("Half of its 95 % interval.")
    chance: Share = D("Probability of such a scale by chance.")
    is_found: bool = D("Whether the chance is below 1 %.")


class AppliedScale(Record):
    scale: float = D("Relative: at 5e-4 the part is 0.5 mm per metre larger than its model.")
    source: str = D("The stated temperature, or what the touches told, in words.")


class FieldShift(Record):
    log_evidence: float = D("Logarithm of how much more probable the residuals are with an error of the robot.")
    centre_mm: Vector = D("Middle of the touches, in base.")
    places_mm: list[Vector] = D("Touches, about the centre.")
    lengths_mm: list[float] = D("Distances over which the robot's error changes.")
    pulls_mm: list[list[Vector]] = D("A vector for each length and place.")
    motion: list[float] = D("What the error did to the pose: rotation vector (rad) and translation (mm) at the centre.")


class RobotField(Record):
    amplitude_mm: NotNegative = D("Standard deviation per axis of the robot's own error.")
    length_mm: Positive = D("Distance over which this error changes.")
    rest_mm: NotNegative = D("Standard deviation per axis of its part that is independent from place to place.")
    origin: Literal["stated", "identified", "pooled", "estimated", "assumed"] = D(
        "Stated (--robot-mm), from held-out poses of the identification, from earlier jobs, from the residuals with "
        "the prior of the class, or the class of uncalibrated six-axis arms."
    )


class Contribution(Record):
    name: Literal["touching", "tool", "robot", "part", "model"]
    type: Literal["A", "B"] = D("A: from these observations; B: known otherwise (GUM).")
    source: str = D("Where its size comes from, in words.")


class SeamBudget(Record):
    seam: str = D("Empty if no seam was given: the fitted points.")
    error_95_mm: NotNegative = D("At the point of the seam with the largest error: expanded uncertainty, 95 %.")
    standard_uncertainty_mm: NotNegative = D("Combined standard uncertainty of this point, in all directions together.")
    coverage_factor: NotNegative | None = D("error_95_mm over standard_uncertainty_mm.")
    degrees_of_freedom: Annotated[float, Meta(ge=1)] | None = D("Behind the combined uncertainty; null if infinite.")
    shares: dict[str, Share] = D("Share of each contribution in the variance.")


class Budget(Record):
    robot: RobotField = D("The robot's own smooth error.")
    contributions: list[Contribution]
    coverage: Share = D("Probability that a point of a seam is off by less than error_95_mm.")
    seams: list[SeamBudget]


class Row(Record):
    criterion: Literal["minimax", "least_squares", "weighted", "robust"]
    objective_mm: NotNegative
    lower_bound_mm: Maybe[NotNegative] = D("No rigid transform has a smaller objective.")
    largest_mm: NotNegative = D("Largest distance of a fitted point.")
    rms_mm: NotNegative
    seam_error_95_mm: NotNegative = D("Largest error along the seams that is not exceeded with 95 % probability.")


class Criteria(Record):
    three_point_frame_mm: Maybe[Annotated[list[NotNegative], Meta(min_length=2, max_length=2)]] = D(
        "Largest distance with a frame through three points, as pendants teach it: by the best three, and the worst."
    )
    rows: list[Row]
    best: Literal["minimax", "least_squares", "weighted", "robust"]
    why: str = D("One sentence.")


class Fit(Record):
    points: Count = D("Number of fitted points.")
    largest_mm: NotNegative = D("Largest distance of a fitted point.")
    rms_mm: NotNegative = D("Root mean square distance of the fitted points.")
    seam_error_95_mm: NotNegative = D("Largest error along the seams that is not exceeded with 95 % probability.")


class Distrusted(Record, rename={"with_": "with"}):
    names: Annotated[list[str], Meta(min_length=1)]
    off_mm: list[NotNegative] = D("How far each of them is from the fit of the others.")
    criterion: Literal["minimax", "least_squares", "weighted", "robust"]
    with_: Fit
    without: Fit
    shift_mm: NotNegative = D("Largest motion of a seam point when they are left out.")
    turn_rad: NotNegative = D("Rotation of the part when they are left out.")


class Rival(Record):
    names: list[str]
    probability: Share


class Exchange(Record):
    name: str = D("Name of the row.")
    feature: str = D("The feature that was probably touched.")
    instead_of: str | None = D("The feature of the row; null if its place is not a feature.")
    largest_mm: NotNegative = D("Largest residual of the least-squares fit with that feature.")


class Suspect(Record):
    names: list[str] = D("Fitted or check points that are named as wrong; empty if the data cannot tell which.")
    off_mm: list[NotNegative] = D("How far each of them is from the least-squares fit of the others.")
    probability: Share | None = D(
        "That these are the wrong ones, if as many are wrong and all were equally likely before. null if none is named."
    )
    at_least: Number = D("Least number of wrong points.")
    rivals: list[Rival] = D("Other points that may be the wrong ones.")
    body: Maybe[str] = D("The body that explains them if it stands elsewhere than in the model.")
    exchanges: list[Exchange] = D("Rows that fit if they were touched on another feature.")
    sentence: str


class ToolOffset(Record):
    tip_mm: Vector = D(
        "From the controller's tool centre point to the tip, along the axes of the tool; 0 along directions that the "
        "postures do not show."
    )
    covariance_mm2: Rotation = D("Covariance of tip_mm.")
    error_95_mm: NotNegative = D("Length that the error of tip_mm stays below in about 95 of 100 repetitions.")
    chance: Share = D("Probability that touches with a right tool centre point leave such residuals.")
    probability: Share = D("That the tool is wrong, and not single touches; both were equally likely before.")
    is_complete: bool = D("Whether the postures show all three directions.")
    sentence: str = D("For a person.")


class EvidenceRival(Record):
    T_base_part: Matrix = D(
        "Homogeneous 4×4 matrix by rows: rotation without unit, translation in mm; the last row is 0 0 0 1."
    )
    rms_mm: NotNegative
    apart_mm: NotNegative = D("Largest distance between the two places of a point of the seams.")


class Evidence(Record):
    starts: Number = D("Starts of the search.")
    agreeing: Count = D("Starts that ended at the answer.")
    next_best_rms_mm: NotNegative | None = D("Root mean square residual of the best other answer; null without one.")
    rivals: Maybe[list[EvidenceRival]] = D(
        "Other places of the part that the touches do not exclude with 95 % confidence. Missing if there are none."
    )


class Freedom(Record):
    motion: str = D("In words, in part coordinates.")
    singular_value: NotNegative = D("Change of all residuals, mm, per mm of this motion at the radius of the touches.")
    held_by: list[str] = D("Touches that hold this motion, the strongest first.")


class Touches(Record):
    lies_on: dict[str, str] = D("What each fitted touch is on, in words, by name.")
    evidence: Evidence
    freedoms: Annotated[list[Freedom], Meta(min_length=6, max_length=6)] = D("The six motions of the part.")


class Trace(Record):
    temperature_mm: list[float]
    f_mm: list[float] = D("Objective.")
    best_f_mm: list[float] = D("Best objective so far.")
    accepted: list[Share] = D("Share of accepted steps.")


class Solver(Record):
    name: Literal["annealing", "exact"]
    method: str = D("In words.")
    schedule: str | None = D("Name of the annealing schedule; null without annealing.")
    seed: int
    evaluations: Count = D("Evaluations by the annealer.")
    temperatures: Count
    starts: Count = D("Local solves.")
    trace: Maybe[Trace] = D("Progress of the annealing, one entry per temperature.")


class Broken(Record):
    bodies: Annotated[list[str], Meta(min_length=2, max_length=2)]
    gap_mm: float = D("The largest gap that the touches show; negative: one body is in the other.")
    expected_mm: Positive = D("Standard deviation of the gap that was allowed.")
    p: Share = D("Probability of such touches if the two stay on each other.")


class Contacts(Record):
    gain: float = D("Twice the logarithm of the likelihood without over that with contacts.")
    p: Share = D("Probability of such a gain if all contacts hold.")
    is_tested: bool = D("Whether the touches see any of the gaps.")
    broken: list[Broken] = D("Pairs of bodies that do not stay on each other, the worst first.")


class Bending(Record):
    axis_part: Vector = D("Along the body, a unit vector in part.")
    normal_part: Vector = D("The direction in which the bow is positive, in part.")
    s_mm: list[float] = D("Places along the axis, from the centre.")
    bow_mm: list[float] = D("Displacement there, beside the motion of the body as a whole.")
    sigma_mm: list[NotNegative] = D("Standard deviations of bow_mm.")


class Body(Record):
    name: str
    touches: Count
    tack_mm: Positive
    tack_mrad: Positive
    centre_part_mm: Vector = D("The point about which the body turns, in the model.")
    moved_mm: Vector = D("Motion of this point, in part.")
    turned_mrad: Vector = D("Rotation vector, in part.")
    sigma_mm: Vector = D("Standard deviations of moved_mm.")
    sigma_mrad: Vector
    p_still: Share = D("Probability of its touches if it alone did not move, corrected for the number of bodies.")
    sigmas: NotNegative = D("The same before the correction, as a number of standard deviations.")
    T_part_moved: Matrix = D("4 x 4 matrix: from the place of the body in the model to its place in the real part, mm.")
    has_moved: bool = D("Whether the touches show that it moved.")
    solids: list[str] = D("The solids that move with it; none for a member of a solid.")
    bending: Maybe[Annotated[list[Bending], Meta(min_length=1)]] = D(
        "With --bending: how it bent, for each direction across its long axis."
    )


class Seam(Record):
    seam: str
    bodies: list[str] = D("The bodies whose faces meet here.")
    never_touched: list[str] = D("Those of them that no touch lies on: their place rests on the tack tolerance.")
    u95_mm: NotNegative = D("Largest 95 % error of a frame.")
    u95_across_mm: NotNegative = D(
        "Largest 95 % error of a frame across the seam: what lies along the seam moves its ends only."
    )
    u95_placing_mm: NotNegative = D("The part of it that the errors of the touches leave.")
    u95_unseen_mm: NotNegative = D("The part of it that motions of the bodies leave which no touch saw.")
    gap_min_mm: float = D("Smallest gap along the seam; negative: the bodies overlap.")
    gap_max_mm: float = D("Largest gap along the seam.")
    gap_u95_mm: NotNegative = D("The gap is off by more, to either side, with 5 % probability.")


class CalibrationBodies(Record):
    sentence: str = D("Whether bodies moved, and which.")
    p_rigid: Share = D("Probability that a rigid part shows touches that fit moved bodies as much better.")
    tolerances: Literal["stated", "assumed", "estimated"] = D(
        "Stated (--tack-mm, --tack-mrad), assumed (1 mm and 3 mrad), or estimated from the touches."
    )
    motions_seen: NotNegative = D("How many motions of bodies the touches see, of six for each body.")
    wrong_touches: list[str] = D(
        "Touches that the others contradict, also if bodies moved as far as their tack tolerances let them."
    )
    far_bodies: Maybe[Annotated[list[str], Meta(min_length=1)]] = D(
        "Bodies that are farther from their places in the model than their tack tolerances explain. Only if there is "
        "one."
    )
    contacts: Maybe[Contacts] = D("What the touches say of kept contacts (--contacts). Only if contacts were kept.")
    bodies: list[Body]
    tolerances_sentence: str = D("The tack tolerances and how they are known, and the bodies that were never touched.")
    gap_limit_mm: Positive = D("Largest gap between members that a seam may have (--gap-mm).")
    seams: list[Seam] = D("The accepted seams: their largest error, and the gap between their bodies.")


class Calibration(Record):
    """wpcal calibration, version 1

    Where a real part is in the robot's base, and how well the touched points agree (calibration.json, wpcal fit
    --json). Lengths in mm, angles in rad.
    """

    schema: Literal["wpcal/calibration/1"]
    inputs: Maybe[Inputs] = D("The files that were used. Not in the result of wpcal fit.")
    files: Maybe[dict[str, Annotated[Sha256, D("SHA-256 of the file's bytes, hexadecimal.")]]] = D(
        "SHA-256 of the moved STEP file and of part.glb as this calibration wrote them, by name. If a file differs, it "
        "is of another run."
    )
    features: Maybe[dict[str, str]] = D(
        "Names of the features that were found for points without a feature, by the name of the point."
    )
    searches: Maybe[Searches] = D("The run of a touch program whose results were fitted. Only with --touches.")
    left_out: Maybe[list[str]] = D("Points that the user left out (use no).")
    robot_space: Space
    verdict: Literal["PASS", "UNSURE", "FAIL"] = D(
        "PASS: the seams are shown to be within tolerance_mm. FAIL: the observations contradict each other or their "
        "stated error, or a seam is shown to be outside. UNSURE: neither is shown."
    )
    judgement: Maybe[Judgement] = D("The verdict as every command and page states it. Older results lack it.")
    criterion_advice: Maybe[str | None] = D(
        "Which other criterion to take, and what it would give; null if the one asked for is as good."
    )
    tolerance_mm: Positive = D("Largest allowed distance of a point.")
    criterion: Literal["minimax", "least_squares", "weighted", "robust"] = D("What the fit minimises.")
    objective_mm: NotNegative = D("Value of the criterion: the largest distance (minimax) or a root mean square.")
    annealed_objective_mm: NotNegative | None = D(
        "Value that simulated annealing reached before the final solver; null without annealing."
    )
    lower_bound_mm: NotNegative = D("No rigid motion has a smaller objective. 0 for touches on faces and edges.")
    gap_mm: NotNegative = D("Objective minus lower bound.")
    certified: bool = D("Whether the lower bound proves that no rigid motion is better by more than 1e-6 mm.")
    rms_mm: NotNegative = D("Root mean square distance of the fitted points.")
    T_base_part: MatrixByRows = D("Carries points from the STEP file's coordinates (part) to the robot's base.")
    pendant: Maybe[dict[str, dict[str, float]]] = D(
        "T_base_part as the pendants of each maker show it: mm, and degrees, a quaternion or (UR) radians."
    )
    correction: Correction = D("T_base_part = T_base_nominal · T_nominal_part.")
    points: list[Point] = D("Fitted points and check points.")
    covariance: CalibrationCovariance = D("Covariance of the small motion of the part about the origin of base.")
    teaching_error: TeachingError = D(
        "Error of one touch: what the user stated, and what the predicted errors rest on. Results of older versions "
        "hold the first only."
    )
    budget: Maybe[Budget] = D("What every predicted error consists of.")
    criteria: Criteria | None = D("All criteria on the same points; null for very many points.")
    distrusted: Maybe[Distrusted | None] = D(
        "Points that the other points contradict, and what leaving them out changes; null if there are none."
    )
    suspect: Maybe[Suspect] = D("What observations say about a wrong one among them. Missing if none is contradicted.")
    scale: Maybe[Scale] = D(
        "How much larger the part is than its model, fitted beside the pose; applied only if applied_scale says so. "
        "Missing for fewer than five observations."
    )
    applied_scale: Maybe[AppliedScale] = D(
        "The size that the seams have: p_base = T_base_part (1 + scale) p_model. Missing for that of the model."
    )
    field_shift: Maybe[FieldShift] = D(
        "By how much the seams follow the robot's own error: those at x, about the centre, are moved by the sum of "
        "pull exp(-d² / 2 length²) over lengths and places at distances d, less the motion at x. Missing if not."
    )
    tool_offset: Maybe[ToolOffset] = D(
        "How far the tip is from the tool centre point of the controller, if the postures of the touches show it. "
        "Missing otherwise."
    )
    issues: list[Issue] = D("What is odd in the points, the part and the files.")
    warnings: Maybe[
        Annotated[
            list[Issue],
            D("Issues of the points alone, in files of versions before 0.2; read issues instead."),
            Meta(extra_json_schema={"deprecated": True}),
        ]
    ]
    touches: Maybe[Touches] = D("For touches on faces and edges only.")
    solver: Solver
    seed: int = D("Seed of all random numbers.")
    versions: dict[str, str] = D("Versions of wpcal and of the libraries behind the numbers.")
    robot2_moved_mm: Maybe[NotNegative] = D(
        "Distance of the measured base of robot 2 from its place in the old cell (wpcal bases only)."
    )
    bodies: Maybe[CalibrationBodies] = D("The motions of the bodies. Only with --bodies.")
