"""Records: batch, job, job-summary, verify, diff, drift, error-study, error, report."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import Count, D, Maybe, NotNegative, Number, Place, Record, Sha256, Share, Vector


class Worst(Record):
    worst_residual_mm: float | None = D("Largest distance of a fitted or a check point, mm.")
    worst_point: str | None = D("Its point.")
    objective_mm: float | None = D("What the criterion minimises, mm.")
    bound_mm: float | None = D("No rigid transform has a smaller objective, mm.")
    worst_seam_error_mm: float | None = D("Largest 95 % error of a frame of an accepted seam, mm; null without one.")
    worst_seam: str | None = D("Its seam.")


class Job(Worst):
    schema: Literal["wpcal/job-summary/1"]
    job: str = D("Name of the job and of its folder.")
    line: Number = D("Line in the list of jobs, counted from 1.")
    part: str = D("As the list names it.")
    taught: str = D("As the list names it.")
    when: str | None = D("When its points were touched, as the list says.")
    verdict: Literal["PASS", "UNSURE", "FAIL", "ERROR"] = D(
        "Verdict of the calibration; ERROR if the job did not end with one."
    )
    pose: Place | None = D(
        "T_base_part: x, y, z in mm, and a, b, c in degrees with R = Rz(c) Ry(b) Rx(a) in the order a, b, c; null if "
        "the job failed."
    )
    seconds: NotNegative | None = D(
        "How long the job took, s: the only field that differs from run to run; null if it failed or is not known."
    )
    error: str | None = D("Why the job failed, in one line.")


class Batch(Record):
    """wpcal batch --json, version 1

    The summary of a batch.
    """

    schema: Literal["wpcal/batch/1"]
    seconds: NotNegative = D("How long this run took, s.")
    kept: Count = D("Jobs that were complete before.")
    verdicts: dict[str, Number] = D("Number of jobs with each verdict.")
    jobs: list[Annotated[Job, D("One job of wpcal batch.")]] = D("The lines of summary.jsonl.")


class Part(Record):
    file: str = D("As the list of jobs or the command names it; - is standard input.")
    sha256: Sha256


class Inputs(Record):
    part: Part
    taught: Part = D("The hash of a folder is that of the names and hashes of its files.")
    options: list[str] = D("As they are typed after wpcal calibrate.")
    files: list[Part] = D("Files that options name, and the files that those name.")
    origins: Maybe[dict[str, str]] = D("Options that were not typed: wpcal.toml with its table, or the variable.")


class Result(Worst):
    verdict: Literal["PASS", "UNSURE", "FAIL"] = D("Verdict of the calibration.")
    pose: Place = D(
        "T_base_part: x, y, z in mm, and a, b, c in degrees with R = Rz(c) Ry(b) Rx(a) in the order a, b, c; null if "
        "the job failed."
    )
    exit_code: Literal[0, 1] = D("With which wpcal calibrate would end.")


class JobRecord(Record):
    """job.json, version 1

    From what the results in a folder of wpcal calibrate or of a job of wpcal batch were made, and what they are.
    """

    schema: Literal["wpcal/job/1"]
    job: Maybe[str] = D("Name of the job of wpcal batch, and of its folder; wpcal calibrate writes none.")
    wpcal: str = D("Version.")
    inputs: Inputs = D("What the results depend on.")
    result: Result = D("The numbers of the summary.")
    files: dict[str, Sha256] = D("SHA-256 of the other files of the folder.")


class JobSummary(Job):
    """A line of summary.jsonl, version 1

    One job of wpcal batch.
    """


class Difference(Record):
    where: str = D("File, seam or point, and field.")
    found: str = D("What is there.")
    expected: str = D("What the inputs or the first result give.")
    off_by: str = D("Number with unit; empty for words.")


class Checked(Record):
    name: str = D("Name of the folder, or summary.jsonl.")
    state: Literal["as claimed", "different", "cannot be checked"] = D("What the check says.")
    version: str | None = D("Version of wpcal that wrote the folder; null for a summary and if it is not known.")
    differences: list[Difference] = D("At most ten of each file.")
    error: str | None = D("Why it cannot be checked, in one line.")
    unchecked: list[str] = D(
        "What is in the folder and not among its results; files of another version of which only some numbers are "
        "compared."
    )
    compared: Maybe[str | None] = D(
        "all digits; or numbers, and which versions of which programs differ; null if nothing was compared."
    )


class Verify(Record):
    """wpcal verify --json, version 1

    Whether results are still what they say.
    """

    schema: Literal["wpcal/verify/1"]
    wpcal: str = D("Version that checked.")
    checked: Annotated[list[Checked], Meta(min_length=1)] = D(
        "The folder; of a batch its summary and the folder of every job that ended with a verdict."
    )
    not_checked: list[str] = D("What cannot be computed from the inputs.")


class Diff(Record):
    """wpcal difference, version 1

    What differs between two result folders (wpcal diff --json).
    """

    schema: Literal["wpcal/diff/1"]
    atol_mm: float = D("Distances up to this count as equal.")
    differences: list[Difference]


class DriftPartPart(Record):
    file: str = D("Name of the STEP file.")
    sha256: str | None = D("Of its contents; null if the calibrations do not say it.")


class Chart(Record):
    unit: str = D("Of all numbers of this chart.")
    centre: float = D("Mean of the first jobs.")
    sigma: NotNegative = D("Scatter from job to job: median moving range / 0.954.")
    lower: float = D("Centre less 3 sigma.")
    upper: float = D("Centre plus 3 sigma.")
    last: float = D("Of the last job.")
    outside: list[str] = D("Jobs outside the limits.")
    cusum_alarms: list[str] = D("Jobs at which the CUSUM exceeds its limit; it then begins again at 0.")


class DriftPartPose(Chart):
    name: Literal["x", "y", "z", "turn x", "turn y", "turn z"]


class Point(Record):
    name: str
    rms_mm: NotNegative = D("Root mean square of the residual.")
    largest_mm: NotNegative
    largest_in_job: str
    mean_base_mm: Vector = D("Mean residual in base.")
    jobs_largest: Count = D("Jobs in which no other point has a larger residual.")
    jobs_named_wrong: Count = D("Jobs whose calibration names the point as wrong.")


class Shift(Record):
    job: str = D("First job after the change.")
    number: Number = D("Its place in the order.")
    when: str | None = D("Its time.")
    cause: Literal["fixture or base", "touch", "robot", "unclear"]
    points: list[str] = D("Of a wrong touch; several if they cannot be told apart.")
    sentence: str = D("For a person.")
    xyz_mm: Vector = D("Change of the middle of the touched points, in base.")
    turn_deg: Vector = D("Change of the turns about the axes of base.")


class DriftPart(Record):
    part: DriftPartPart
    jobs: Annotated[int, Meta(ge=8)] = D("Jobs with a calibration.")
    first_job: str
    last_job: str
    order: Literal["when", "list"] = D(
        "when: by the times of the jobs. list: not all jobs have a time; the order is that of the folders and their "
        "lists."
    )
    centre_from_jobs: Number = D("This many first jobs give the centres.")
    pose: Annotated[list[DriftPartPose], Meta(min_length=6, max_length=6)] = D(
        "Place of the middle of the touched points and turn of the part, both from the median pose, along the axes of "
        "base."
    )
    points: list[Point] = D("Points that are in all jobs.")
    points_not_in_all_jobs: list[str] = D("Not looked at.")
    most_wrong: str | None = D(
        "Point that most jobs name as wrong; if none does, the one that most often has the largest residual. null "
        "without residuals."
    )
    seam_error: Chart | None = D("Largest 95 % error of a seam; null if a job has none.")
    shifts: list[Shift] = D("Sudden changes.")
    corrected: Maybe[list[str]] = D("What was corrected alike on the pendant in most jobs (touchup.json).")


class Failed(Record):
    job: str
    out: str = D("Folder of the batch.")
    error: str


class Rule(Record):
    name: str
    rule: str
    false_alarm: str


class Drift(Record):
    """wpcal drift, version 1

    What changes from job to job of each part (drift.json).
    """

    schema: Literal["wpcal/drift/1"]
    parts: Annotated[list[DriftPart], Meta(min_length=1)]
    failed: list[Failed] = D("Jobs without a calibration.")
    left_out: list[str] = D("One line for each part with too few jobs.")
    rules: list[Rule] = D("When something is an alarm, and how often without cause.")


class Histogram(Record):
    edges_mm: Annotated[list[NotNegative], Meta(min_length=2)] = D("One more than counts.")
    counts: Annotated[list[Count], Meta(min_length=1)] = D("Trials per bin.")


class ErrorStudy(Record, rename={"share_below_0_5_mm": "share_below_0.5_mm"}):
    """wpcal error study, version 1

    Simulated errors of calibrations (wpcal study --json).
    """

    schema: Literal["wpcal/error-study/1"]
    trials: Number
    bound_mm: NotNegative = D("Greatest error of a taught coordinate.")
    at: Literal["cube", "corners", "common"] = D("Where in the cube of half width bound_mm the errors are.")
    criterion: Literal["minimax", "least_squares"]
    seed: int
    mean_mm: NotNegative = D("Mean error of a trial.")
    extreme_mm: NotNegative = D("Largest error of a trial.")
    budget_95_mm: NotNegative = D("95 % error of all points with the errors of robot, tool and part (error budget).")
    share_below_0_5_mm: Share = D("Share of the trials with an error below 0.5 mm.")
    quantiles_mm: Annotated[dict[str, NotNegative], Meta(min_length=1)] = D("Error by probability (0.95 and so on).")
    histogram: Histogram


class Error(Record):
    """wpcal error, version 1

    What a command with --json prints on stdout when it fails. The same is one line on stderr.
    """

    schema: Literal["wpcal/error/1"]
    exit_code: Number
    code: str = D("The cause, for programs: a code of wpcal.core.errors.ErrorCode, or usage, internal, interrupted.")
    file: str | None = D("The file that it is about; null if none is known.")
    line: Number | None = D("Line of the file, from 1.")
    column: str | None = D("Name of a column, or its place in the line, from 1.")
    message: str = D("What is wrong and what was expected.")
    hint: str | None = D("The options that help; null if none is known.")


class Report(Record):
    """wpcal report, version 1

    The page that wpcal report wrote (wpcal report --json).
    """

    schema: Literal["wpcal/report/1"]
    verdict: Literal["PASS", "UNSURE", "FAIL"] = D("Verdict of the calibration, as in calibration.json.")
    file: str = D("The written page.")


class ShopValue(Record):
    option: str = D("As it is typed.")
    value: str
    origin: str = D("wpcal.toml, with its table if there is one, or the variable.")
    commands: list[str] = D("The commands that take it.")


class LearnedRule(Record):
    option: Literal["not", "weld"]
    pattern: str = D("Of names of solids, with a star.")
    saved: list[str] = D("Decisions by hand that the rule would have saved: a seam with its solids, or a solid.")
    wrong: list[str] = D("Seams that the rule would have judged otherwise than was decided.")
    parts: Number = D("On how many parts it saves a decision.")


class ShopRules(Record):
    """wpcal shop learn --json, version 1

    What was decided by hand again and again, as rules.
    """

    schema: Literal["wpcal/shop-rules/1"]
    decisions: Count = D("Decisions by hand in the results.")
    rules: list[LearnedRule]


class Shop(Record):
    """wpcal shop --json, version 1

    What a shop says once.
    """

    schema: Literal["wpcal/shop/1"]
    file: str | None = D("The file wpcal.toml; null if there is none above the folder.")
    values: list[ShopValue]
