"""What the methods of `wpcal rpc` take and return: one type per method, with `params` and `result`."""

from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta

from wpcal.records.parts import Count, D, Matrix, Maybe, Open, Record, Rotation, Text, Vector, inlined
from wpcal.records.schema import DRAFT


class ResultLine(Record):
    id: int | str
    result: dict[str, Any]


class Error(Record):
    kind: str
    code: str
    message: str
    hint: str | None
    path: Maybe[str | None] = UNSET
    line: Maybe[int | None] = UNSET
    column: Maybe[str | int | None] = UNSET
    row: Maybe[Count | None] = UNSET


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
    columns: Maybe[list[str]] = UNSET
    rows: Maybe[list[list[str]]] = UNSET
    path: Maybe[Annotated[Text, D("A table, a program, or the results of a touch program.")]] = UNSET
    touches: Maybe[Annotated[Text, D("The plan touches.json whose program stored the results.")]] = UNSET
    setup: Maybe[Annotated[Text, D("The touch setup of the cell.")]] = UNSET


class Decision(Record):
    candidate: Annotated[dict[str, Any], D("The candidate of a seam, as in seams.json.")]
    edit: Annotated[dict[str, Any], D("As in seams.json: accept, reject, reverse, name, range_mm, other_side, join.")]


class Params(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    taught: Annotated[Taught, D("Touched points: columns and rows of text, or the path of a file.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET
    decisions: Maybe[Annotated[list[Decision], D("Decisions about seams.")]] = UNSET
    frames: Maybe[Annotated[bool, D("Also return the seams with their frames in base.")]] = UNSET


class ResultRecord(Open):
    schema: Literal["wpcal/calibration/1"]


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
    s: Annotated[list[float] | None, D("Length along the seam, mm.")]
    p: Annotated[list[Vector] | None, D("Points, mm.")]
    R: Annotated[list[Rotation] | None, D("Axes x, y, z as columns.")]
    u95: Maybe[list[float] | None] = UNSET
    slope: Maybe[list[float] | None] = UNSET
    rotation: Maybe[list[float | None] | None] = UNSET
    position: Maybe[list[str | None] | None] = UNSET


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
    candidate: Maybe[Annotated[dict[str, Any], D("The candidate of a seam, as in seams.json.")]] = UNSET
    edit: Maybe[dict[str, Any]] = UNSET
    frames: Frames


class Result(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    record: Annotated[ResultRecord, D("The record wpcal/calibration/1.")]
    T_base_part: Annotated[Matrix, D("Row by row, mm.")]
    points: list[Point]
    features: Annotated[dict[str, str], D("The feature of every row, by the number of the row.")]
    u95_mm: Annotated[list[U95Mm], D("95 % error at every frame of each seam.")]
    seams: list[Annotated[Seam, D("As in seams.json; its frames are columns.")]] | None
    notes: Annotated[list[str], D("What is odd.")]
    steps: Annotated[list[str], D("What to do next.")]


class Calibrate(Record):
    """wpcal rpc calibrate, version 1

    Fit a part; nothing is written. Method calibrate of wpcal rpc.
    """

    params: Maybe[Params] = UNSET
    result: Maybe[Result] = UNSET


class CancelParams(Record):
    id: Annotated[int | str, D("Of the request.")]


class CancelResult(Record):
    cancelled: bool


class Cancel(Record):
    """wpcal rpc cancel, version 1

    Cancel a request. Method cancel of wpcal rpc.
    """

    params: Maybe[CancelParams] = UNSET
    result: Maybe[CancelResult] = UNSET


class CloseParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]


class CloseResult(Record):
    pass


class Close(Record):
    """wpcal rpc close, version 1

    Forget a part. Method close of wpcal rpc.
    """

    params: Maybe[CloseParams] = UNSET
    result: Maybe[CloseResult] = UNSET


class ExportParams(Record):
    folder: Annotated[Text, D("A result folder, or one with a touch plan.")]
    formats: Annotated[Annotated[list[Text], Meta(min_length=1)], D("Names of formats or makers.")]
    out: Maybe[Annotated[Text, D("A folder to write into.")]] = UNSET
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET


class ExportResult(Open):
    schema: Literal["wpcal/export/1"]


class Export(Record):
    """wpcal rpc export, version 1

    Write programs. Method export of wpcal rpc.
    """

    params: Maybe[ExportParams] = UNSET
    result: Maybe[Annotated[ExportResult, D("The record wpcal/export/1.")]] = UNSET


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


class Formats(Record):
    """wpcal rpc formats, version 1

    The formats of export. Method formats of wpcal rpc.
    """

    params: Maybe[CloseResult] = UNSET
    result: Maybe[FormatsResult] = UNSET


class HelloResult(Record):
    wpcal: str
    protocol: Literal[1]
    methods: list[str]


class Hello(Record):
    """wpcal rpc hello, version 1

    The first request. Method hello of wpcal rpc.
    """

    params: Maybe[CloseResult] = UNSET
    result: Maybe[HelloResult] = UNSET


class OpenParams(Record):
    path: Annotated[Text, D("A STEP file.")]


class Feature(Open):
    name: str
    kind: str
    p_mm: Vector
    direction: Vector | None
    diameter_mm: float | None
    solid: str | None
    touch: str | None
    faces: Maybe[list[Any]] = UNSET
    ease: str


class OpenResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    path: str
    unit: str
    size: str
    solids: list[str]
    features: Annotated[list[Feature], D("As in wpcal/features/1.")]
    members: list[dict[str, Any]]
    notes: Annotated[list[str], D("What is odd.")]


class OpenOpen(Record):
    """wpcal rpc open, version 1

    Read a STEP file. Method open of wpcal rpc.
    """

    params: Maybe[OpenParams] = UNSET
    result: Maybe[OpenResult] = UNSET


class OptionsParams(Record):
    method: str


class OptionsResult(Record):
    options: list[Option]


class Options(Record):
    """wpcal rpc options, version 1

    The options of a method. Method options of wpcal rpc.
    """

    params: Maybe[OptionsParams] = UNSET
    result: Maybe[OptionsResult] = UNSET


class PageParams(Record):
    folder: Annotated[Text, D("A result folder.")]


class PageResult(Record):
    path: str


class Page(Record):
    """wpcal rpc page, version 1

    The page of a result folder. Method page of wpcal rpc.
    """

    params: Maybe[PageParams] = UNSET
    result: Maybe[PageResult] = UNSET


class PlanParams(Record):
    folder: Annotated[Text, D("A result folder.")]
    cell: Annotated[Text, D("The cell.")]
    out: Annotated[Text, D("A folder to write into.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET


class Plan(Record):
    """wpcal rpc plan, version 1

    Plan welds in a cell and write the plan. Method plan of wpcal rpc.
    """

    params: Maybe[PlanParams] = UNSET
    result: Maybe[Annotated[dict[str, Any], D("The record of the command.")]] = UNSET


class ReadTaughtParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    path: Annotated[Text, D("A table or a program; with text only its name.")]
    text: Maybe[Annotated[str, D("The content, if there is no file.")]] = UNSET
    touches: Maybe[Annotated[Text, D("The plan touches.json whose program stored the results.")]] = UNSET
    setup: Maybe[Annotated[Text, D("The touch setup of the cell.")]] = UNSET
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET


class ReadTaughtResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    columns: list[str]
    rows: list[list[str]]
    left_out: list[str]
    notes: Annotated[list[str], D("What is odd.")]


class ReadTaught(Record):
    """wpcal rpc read_taught, version 1

    Rows of a file. Method read_taught of wpcal rpc.
    """

    params: Maybe[ReadTaughtParams] = UNSET
    result: Maybe[ReadTaughtResult] = UNSET


class SaveParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    taught: Annotated[Taught, D("Touched points: columns and rows of text, or the path of a file.")]
    table: Maybe[Annotated[Text, D("The file in which rows of the request are written.")]] = UNSET
    out: Annotated[Text, D("The result folder.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET
    decisions: Maybe[Annotated[list[Decision], D("Decisions about seams.")]] = UNSET


class SaveResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    record: Annotated[ResultRecord, D("The record wpcal/calibration/1.")]
    files: list[str]
    notes: Annotated[list[str], D("What is odd.")]
    command: str


class Save(Record):
    """wpcal rpc save, version 1

    Write the result folder. Method save of wpcal rpc.
    """

    params: Maybe[SaveParams] = UNSET
    result: Maybe[SaveResult] = UNSET


class SeamsParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET
    decisions: Maybe[Annotated[list[Decision], D("Decisions about seams.")]] = UNSET


class SeamsResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    frame: Maybe[Literal["part"]] = UNSET
    judging: Maybe[dict[str, Any]] = UNSET
    members: Maybe[list[dict[str, Any]]] = UNSET
    join_mm: Maybe[float] = UNSET
    torch: Maybe[dict[str, Any]] = UNSET
    seams: list[Annotated[Seam, D("As in seams.json; its frames are columns.")]]
    notes: Annotated[list[str], D("What is odd.")]


class Seams(Record):
    """wpcal rpc seams, version 1

    The seams of a part. Method seams of wpcal rpc.
    """

    params: Maybe[SeamsParams] = UNSET
    result: Maybe[SeamsResult] = UNSET


class Shutdown(Record):
    """wpcal rpc shutdown, version 1

    End the process. Method shutdown of wpcal rpc.
    """

    params: Maybe[CloseResult] = UNSET
    result: Maybe[CloseResult] = UNSET


class SuggestParamsTaught(Record):
    columns: list[str]
    rows: list[list[str]]


class SuggestParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    taught: Annotated[SuggestParamsTaught, D("The rows so far.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET
    decisions: Maybe[Annotated[list[Decision], D("Decisions about seams.")]] = UNSET


class Touch(Record):
    name: str
    where: str
    body: str
    seam: str
    before_mm: float | None
    after_mm: float | None
    sentence: str


class SuggestResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    features: list[str]
    error_95_mm: float
    seam: str
    sigma_mm: float
    touches: Maybe[
        Annotated[
            list[Touch],
            D(
                "Only if bodies may have moved: what each feature is for. An error is null while the touches "
                "leave the part free."
            ),
        ]
    ] = UNSET


class Suggest(Record):
    """wpcal rpc suggest, version 1

    The features to touch next. Method suggest of wpcal rpc.
    """

    params: Maybe[SuggestParams] = UNSET
    result: Maybe[SuggestResult] = UNSET


class TouchAtParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    p_mm: Annotated[Vector, D("In the part.")]
    normal: Annotated[Vector, D("Outward, in the part.")]


class TouchAtResult(Record):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    kind: str
    p_mm: Vector
    normal: Vector
    border_mm: float


class TouchAt(Record):
    """wpcal rpc touch_at, version 1

    What a click on the part touches. Method touch_at of wpcal rpc.
    """

    params: Maybe[TouchAtParams] = UNSET
    result: Maybe[TouchAtResult] = UNSET


class TouchesParams(Record):
    handle: Annotated[str, D("Handle of an opened part, from the method open.")]
    out: Annotated[Text, D("A folder to write into.")]
    options: Maybe[
        Annotated[dict[str, Any], D("Options of the command, without dashes and with underscores (method options).")]
    ] = UNSET
    decisions: Maybe[Annotated[list[Decision], D("Decisions about seams.")]] = UNSET


class TouchesResult(Open):
    handle: str
    sha256: Annotated[str, D("Hash of the part's file.")]
    reread: Annotated[bool, D("Whether the file changed and was read again.")]
    schema: Literal["wpcal/touches/1"]


class Touches(Record):
    """wpcal rpc touches, version 1

    Plan touches and write the plan. Method touches of wpcal rpc.
    """

    params: Maybe[TouchesParams] = UNSET
    result: Maybe[TouchesResult] = UNSET


METHODS: dict[str, type[Record]] = {
    "calibrate": Calibrate,
    "cancel": Cancel,
    "close": Close,
    "export": Export,
    "formats": Formats,
    "hello": Hello,
    "open": OpenOpen,
    "options": Options,
    "page": Page,
    "plan": Plan,
    "read_taught": ReadTaught,
    "save": Save,
    "seams": Seams,
    "shutdown": Shutdown,
    "suggest": Suggest,
    "touch_at": TouchAt,
    "touches": Touches,
}
"""By the name of the method."""


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
