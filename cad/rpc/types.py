"""What the methods of `wpcal rpc` take and return: one type per method, with `params` and `result`."""

from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from wpcal.core.record_types.parts import Count, D, Matrix, Maybe, Open, Record, Rotation, Text, Vector, inlined
from wpcal.core.record_types.schema import DRAFT

Handle = Annotated[str, D("Handle of an opened part, from the method open.")]
Given = Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
Notes = Annotated[list[str], D("What is odd.")]


class ResultLine(Record):
    id: int | str
    result: dict[str, Any]


class Error(Record):
    kind: str
    code: str
    message: str
    hint: str | None
    path: Maybe[str | None]
    line: Maybe[int | None]
    column: Maybe[str | int | None]
    row: Maybe[Count | None]


class ErrorLine(Record):
    id: int | str | None
    error: Error


class Progress(Record):
    text: str
    done: Count | None
    of: Count | None


class ProgressLine(Record):
    id: int | str
    progress: Progress


class Taught(Record):
    columns: Maybe[list[str]]
    rows: Maybe[list[list[str]]]
    path: Maybe[Text] = D("A table, a program, or the results of a touch program.")
    touches: Maybe[Text] = D("The plan touches.json whose program stored the results.")
    setup: Maybe[Text] = D("The touch setup of the cell.")


class Decision(Record):
    candidate: dict[str, Any] = D("The candidate of a seam, as in seams.json.")
    edit: dict[str, Any] = D("As in seams.json: accept, reject, reverse, name, range_mm, other_side, join.")


Decisions = Annotated[list[Decision], D("Decisions about seams.")]


class Params(Record):
    handle: Handle
    taught: Taught = D("Touched points: columns and rows of text, or the path of a file.")
    options: Maybe[Given]
    decisions: Maybe[Decisions]
    frames: Maybe[bool] = D("Also return the seams with their frames in base.")


class ResultRecord(Open):
    schema: Literal["wpcal/calibration/1"]


CalibrationRecord = Annotated[ResultRecord, D("The record wpcal/calibration/1.")]


class OnPart(Record):
    handle: str
    sha256: str = D("Hash of the part's file.")
    reread: bool = D("Whether the file changed and was read again.")


class Point(Open):
    name: str
    row: Count
    residual_mm: Vector
    residual_part_mm: Vector


class U95Mm(Record):
    seam: str
    accepted: bool
    max_mm: float | None
    frames_mm: list[float]


class Frames(Open):
    s: list[float] | None = D("Length along the seam, mm.")
    p: list[Vector] | None = D("Points, mm.")
    R: list[Rotation] | None = D("Axes x, y, z as columns.")
    u95: Maybe[list[float] | None]
    slope: Maybe[list[float] | None]
    rotation: Maybe[list[float | None] | None]
    position: Maybe[list[str | None] | None]


class Seam(Open):
    name: str
    joint: str
    weld: str
    solids: list[str]
    closed: bool
    length_mm: float
    accepted: bool
    confidence: float
    reasons: list[str]
    against: list[str]
    candidate: Maybe[dict[str, Any]] = D("The candidate of a seam, as in seams.json.")
    edit: Maybe[dict[str, Any]]
    frames: Frames


SeamInColumns = Annotated[Seam, D("As in seams.json; its frames are columns.")]


class Result(OnPart):
    record: CalibrationRecord
    T_base_part: Matrix = D("Row by row, mm.")
    points: list[Point]
    features: dict[str, str] = D("The feature of every row, by the number of the row.")
    u95_mm: list[U95Mm] = D("95 % error at every frame of each seam.")
    seams: list[SeamInColumns] | None
    notes: Notes
    steps: list[str] = D("What to do next.")


class CancelParams(Record):
    id: int | str = D("Of the request.")


class CancelResult(Record):
    cancelled: bool


class CloseParams(Record):
    handle: Handle


class CloseResult(Record):
    pass


class ExportParams(Record):
    folder: Text = D("A result folder, or one with a touch plan.")
    formats: Annotated[list[Text], Meta(min_length=1)] = D("Names of formats or makers.")
    out: Maybe[Text] = D("A folder to write into.")
    options: Maybe[Given]


class ExportResult(Open):
    schema: Literal["wpcal/export/1"]


class Format(Record):
    name: str
    title: str
    brands: list[str]


class Option(Record):
    name: str
    type: Literal["number", "integer", "boolean", "string"]
    repeated: bool
    default: Any
    choices: list[str] | None
    help: str


class FormatsResult(Record):
    formats: list[Format]
    options: list[Option]


class HelloResult(Record):
    wpcal: str
    protocol: Literal[1]
    methods: list[str]


class OpenParams(Record):
    path: Text = D("A STEP file.")


class Feature(Open):
    name: str
    kind: str
    p_mm: Vector
    direction: Vector | None
    diameter_mm: float | None
    solid: str | None
    touch: str | None
    faces: Maybe[list[Any]]
    ease: str


class OpenResult(OnPart):
    path: str
    unit: str
    size: str
    solids: list[str]
    features: list[Feature] = D("As in wpcal/features/1.")
    notes: Notes


class OptionsParams(Record):
    method: str


class OptionsResult(Record):
    options: list[Option]


class PageParams(Record):
    folder: Text = D("A result folder.")


class PageResult(Record):
    path: str


class PlanParams(Record):
    folder: Text = D("A result folder.")
    cell: Text = D("The cell.")
    out: Text = D("A folder to write into.")
    options: Maybe[Given]


class ReadTaughtParams(Record):
    handle: Handle
    path: Text = D("A table or a program; with text only its name.")
    text: Maybe[str] = D("The content, if there is no file.")
    touches: Maybe[Text] = D("The plan touches.json whose program stored the results.")
    setup: Maybe[Text] = D("The touch setup of the cell.")
    options: Maybe[Given]


class ReadTaughtResult(OnPart):
    columns: list[str]
    rows: list[list[str]]
    left_out: list[str]
    notes: Notes


class SaveParams(Record):
    handle: Handle
    taught: Taught = D("Touched points: columns and rows of text, or the path of a file.")
    table: Maybe[Text] = D("The file in which rows of the request are written.")
    out: Text = D("The result folder.")
    options: Maybe[Given]
    decisions: Maybe[Decisions]


class SaveResult(OnPart):
    record: CalibrationRecord
    files: list[str]
    notes: Notes
    command: str


class SeamsParams(Record):
    handle: Handle
    options: Maybe[Given]
    decisions: Maybe[Decisions]


class SeamsResult(OnPart):
    frame: Maybe[Literal["part"]]
    judging: Maybe[dict[str, Any]]
    members: Maybe[list[dict[str, Any]]]
    join_mm: Maybe[float]
    torch: Maybe[dict[str, Any]]
    seams: list[SeamInColumns]
    notes: Notes


class SuggestParamsTaught(Record):
    columns: list[str]
    rows: list[list[str]]


class SuggestParams(Record):
    handle: Handle
    taught: SuggestParamsTaught = D("The rows so far.")
    options: Maybe[Given]
    decisions: Maybe[Decisions]


class Touch(Record):
    name: str
    where: str
    body: str
    seam: str
    before_mm: float | None
    after_mm: float | None
    sentence: str


class SuggestResult(OnPart):
    features: list[str]
    error_95_mm: float
    seam: str
    sigma_mm: float
    touches: Maybe[list[Touch]] = D(
        "Only if bodies may have moved: what each feature is for. An error is null while the touches leave the part "
        "free."
    )


class TouchAtParams(Record):
    handle: Handle
    p_mm: Vector = D("In the part.")
    normal: Vector = D("Outward, in the part.")


class TouchAtResult(OnPart):
    kind: str
    p_mm: Vector
    normal: Vector
    border_mm: float | None = D("Null of a face without a border, such as a whole torus.")


class TouchesParams(Record):
    handle: Handle
    out: Text = D("A folder to write into.")
    options: Maybe[Given]
    decisions: Maybe[Decisions]


class TouchesResult(Open):
    handle: str
    sha256: str = D("Hash of the part's file.")
    reread: bool = D("Whether the file changed and was read again.")
    schema: Literal["wpcal/touches/1"]


METHODS: dict[str, tuple[str, Any, Any]] = {
    "calibrate": ("Fit a part; nothing is written.", Params, Result),
    "cancel": ("Cancel a request.", CancelParams, CancelResult),
    "close": ("Forget a part.", CloseParams, CloseResult),
    "export": ("Write programs.", ExportParams, Annotated[ExportResult, D("The record wpcal/export/1.")]),
    "formats": ("The formats of export.", CloseResult, FormatsResult),
    "hello": ("The first request.", CloseResult, HelloResult),
    "open": ("Read a STEP file.", OpenParams, OpenResult),
    "options": ("The options of a method.", OptionsParams, OptionsResult),
    "page": ("The page of a result folder.", PageParams, PageResult),
    "plan": (
        "Plan welds in a cell and write the plan.",
        PlanParams,
        Annotated[dict[str, Any], D("The record of the command.")],
    ),
    "read_taught": ("Rows of a file.", ReadTaughtParams, ReadTaughtResult),
    "save": ("Write the result folder.", SaveParams, SaveResult),
    "seams": ("The seams of a part.", SeamsParams, SeamsResult),
    "shutdown": ("End the process.", CloseResult, CloseResult),
    "suggest": ("The features to touch next.", SuggestParams, SuggestResult),
    "touch_at": ("What a click on the part touches.", TouchAtParams, TouchAtResult),
    "touches": ("Plan touches and write the plan.", TouchesParams, TouchesResult),
}
"""By the name of the method: what it does, its ``params``, and its ``result``."""


def method_type(name: str) -> type[Struct]:
    """Return the type of which a method has the fields ``params`` and ``result``."""
    what, params, result = METHODS[name]
    said = f"wpcal rpc {name}, version 1\n\n{what} Method {name} of wpcal rpc."
    kinds = {"params": params | UnsetType, "result": result | UnsetType}
    fields = {"__doc__": said, "__annotations__": kinds, **dict.fromkeys(kinds, UNSET)}
    found: type[Struct] = type(Record)(name, (Record,), fields)
    return found


def answer_schema() -> dict[str, Any]:
    """Return the JSON Schema of every line that is sent."""
    return {
        "$schema": DRAFT,
        "$id": "urn:wpcal:schema:rpc-answer:1",
        "title": "wpcal rpc, version 1",
        "description": "A line that wpcal rpc sends: a result, an error or progress. Results are described by the "
        "schemas of the methods.",
        "oneOf": inlined(ResultLine, ErrorLine, ProgressLine),
    }
