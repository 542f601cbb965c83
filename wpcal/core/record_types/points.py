"""Records: taught, match, features, bodies, pick-draft, sheet."""

from typing import Annotated, Any, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    Count,
    D,
    FeatureOfPart,
    Issue,
    MatrixByRows,
    Maybe,
    NotNegative,
    Number,
    Positive,
    Record,
    Sha256,
    Share,
    Text,
    Vector,
    one_of,
)


class Point(Record):
    name: str
    p_base_mm: Vector = D("x, y, z in base, mm.")
    feature: Maybe[str] = D("Name of the feature that the point is; empty if it is not known.")
    rx_ry_rz_deg: Maybe[Vector | None] = D("Posture of the tool in base, R = Rz Ry Rx; null if it is not told.")


class Taught(Record):
    """wpcal taught points, version 1

    Points read from a robot program (wpcal taught --json).
    """

    schema: Literal["wpcal/taught/1"]
    robot_space: Maybe[Literal["nominal", "identified"]] = D("Robot model behind the points.")
    points: list[Point]


class Answer(Record):
    features: list[str] = D("One feature per point, in the order of points.")
    rms_mm: NotNegative = D("Root mean square distance of the least-squares fit.")
    probability: Share = D("Among all answers, for Gaussian errors.")
    T_base_part: MatrixByRows = D("Carries points from part to base.")


class Match(Record):
    """wpcal match, version 1

    Which feature each taught point is (wpcal match --json).
    """

    schema: Literal["wpcal/match/1"]
    points: list[str] = D("Names of the taught points.")
    chosen: Count | None = D("Index of the chosen answer, counted from 0; null if the data cannot decide.")
    reason: str = D("Why it is chosen, or what would decide.")
    complete: bool = D("False if there are more answers than are listed.")
    answers: list[Answer] = D("The best fit first.")


class Feature(FeatureOfPart):
    ease: Literal["sharp", "round", "hidden", "vague", "indirect"] = D("How well it can be touched, the best first.")


class Features(Record):
    """wpcal features, version 1

    Reference features of a part (wpcal features --json). Points in part, lengths in mm.
    """

    schema: Literal["wpcal/features/1"]
    features: list[Feature]
    issues: list[Issue] = D("What is odd in the part's file.")


class Body(Record):
    name: str
    solids: Maybe[Annotated[list[str], Meta(min_length=1)]] = D(
        "Names of solids that move as one; * and ? match any letters. Without it, the solid of this name."
    )
    faces: Maybe[Number] = D("How many faces it has. Written to recognise the body by; not read.")
    centre_mm: Maybe[Vector] = D("Middle of the box around it, in part. Written to recognise the body by; not read.")
    size_mm: Maybe[Vector] = D("Sides of the box around it. Written to recognise the body by; not read.")
    tack_mm: Maybe[float] = D("Standard deviation of its motion along every axis.")
    tack_mrad: Maybe[float] = D("Standard deviation of its turn about every axis.")


class Bodies(Record):
    """wpcal bodies, version 1

    Which bodies of a part may have moved, and how far (wpcal calibrate --bodies FILE). `wpcal bodies` writes one to
    edit.
    """

    schema: Literal["wpcal/bodies/1"]
    bodies: list[Body]


class Part(Record):
    file: str = D("File name.")
    sha256: Sha256 = D("Of the file's bytes.")


class PickDraftBodies(Record):
    is_on: bool
    tack_mm: Positive | None = D("--tack-mm; null if it is not stated.")
    bending_mm: Positive | None = D("--bending; null without it.")
    keeps_contacts: bool = D("--contacts")
    contact_mm: Positive | None = D("The number of --contacts; null without one.")
    tack_mrad: Positive | None = D("--tack-mrad; null if it is not stated.")


class Table(Record):
    columns: Annotated[list[str], Meta(extra_json_schema={"uniqueItems": True})] = D("As in a table of taught points.")
    rows: list[list[str]] = D("Row by row; cells are text as typed.")
    keys: Annotated[list[Text], Meta(extra_json_schema={"uniqueItems": True})] = D(
        "One per row. A row keeps its key when its cells change."
    )


class PickDraft(Record):
    """wpcal pick draft, version 1

    The table of taught points while it is edited in wpcal pick (taught.csv.draft): rows that are not saved yet, or
    have no coordinates.
    """

    schema: Literal["wpcal/pick-draft/1"]
    part: Part = D("The part on which the points are taught.")
    file_sha256: Sha256 | None = D("Of the saved table from which the rows were made; null if there was none.")
    bodies: Maybe[PickDraftBodies] = D("Whether bodies may have moved (--bodies); without it they may not.")
    table: Table


class SheetPart(Record):
    file: str = D("Name of the STEP file.")
    sha256: Annotated[str, Meta(pattern="^([0-9a-f]{64})?$")] = D("SHA-256 of the file; empty for shapes of a script.")


class SheetFeature(FeatureOfPart):
    number: Number = D("Number on the sheet.")


class Touch(Record):
    """A touch on a face or an edge: of a plan, or of a table with the column kind."""

    number: Number = D("Number on the sheet.")
    name: str
    kind: Literal["point", "plane", "edge", "hole", "cylinder", "sphere", "surface"]
    p_mm: Annotated[Vector, D("x, y, z in mm.")] = D("Where the part is touched, in part.")
    way: Annotated[Vector, D("Unit vector.")] | None = D(
        "Direction of the move towards the face, in part; null if none is known."
    )
    words: str = D("As the table of the sheet has it.")


class SheetWeld(Record):
    number: Number = D("Number on the sheet.")
    name: str = D("Of its seam.")
    p_mm: Annotated[Vector, D("x, y, z in mm.")] = D("Its middle, in part.")
    welded_mm: NotNegative = D("Length of all its stretches.")
    words: str = D("As the table of the sheet has it.")


class Sheet(Record):
    """wpcal teach sheet, version 1

    What is on a teach sheet (wpcal sheet --json). Points in part, lengths in mm.
    """

    schema: Literal["wpcal/sheet/1"]
    part: SheetPart
    paper: Literal["A3", "A4"]
    scale: Annotated[str, Meta(pattern="^([0-9.]+:1|1:[0-9.]+)$")] = D("Scale of the orthogonal views.")
    points: list[Annotated[Any, one_of(SheetFeature, Touch)]] = D("To touch; none on a list of welds.")
    welds: Maybe[list[SheetWeld]] = D("On a list of welds.")
    issues: list[Issue] = D("What is odd in the part's file.")
