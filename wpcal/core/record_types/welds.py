"""Records: welds, weld-rules."""

from typing import Annotated, Any, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import D, Maybe, NotNegative, Number, Pair, Record, Text, Vector
from wpcal.core.record_types.plans import Units


class Place(Record):
    """By which the seam is recognised under another name, in coordinates of the part."""

    start_part_mm: Vector
    middle_part_mm: Vector
    length_mm: NotNegative


class Weave(Record):
    shape: Literal["zigzag", "sine", "triangle", "circle"]
    width_mm: Annotated[float, Meta(gt=0, le=100)] = D("From side to side.")
    length_mm: Annotated[float, Meta(gt=0, le=1000)] = D("Along the seam, per swing to and fro.")
    dwell_left_s: Maybe[Annotated[float, Meta(ge=0, le=100)]] = D("Pause at the side of +y.")
    dwell_right_s: Maybe[Annotated[float, Meta(ge=0, le=100)]] = D("Pause at the side of -y.")


class Crater(Record):
    time_s: Annotated[float, Meta(ge=0, le=100)]
    current_a: Maybe[Annotated[float, Meta(gt=0, le=2000)]] = D("Without it that of the weld.")
    voltage_v: Maybe[Annotated[float, Meta(gt=0, le=100)]] = D("Without it that of the weld.")


class Stitch(Record):
    length_mm: Annotated[float, Meta(gt=0, le=100000)] = D("Of each stretch.")
    pitch_mm: Annotated[float, Meta(gt=0, le=100000)] = D("From the start of a stretch to the start of the next.")
    offset_mm: Maybe[Annotated[float, Meta(ge=0, le=100000)] | None] = D(
        "From the start of the seam to the first stretch; null or missing: the same length is left free at both ends."
    )


class Values(Record):
    """What is welded.

    Change a value to state it; delete it to get that of the rules; null states that there
    is none.
    """

    thickness_mm: Maybe[Annotated[float, Meta(gt=0, le=1000)] | None] = D("Of the thinner plate.")
    position: Maybe[Literal["PA", "PB", "PC", "PD", "PE", "PF", "PG"] | None] = D("Weld position of ISO 6947.")
    weld: Maybe[
        Literal[
            "fillet weld",
            "square butt weld",
            "single-V butt weld",
            "single-bevel butt weld",
            "double-V butt weld",
            "double-bevel butt weld",
            "flare-V weld",
            "flare-bevel weld",
        ]
        | None
    ] = D("In words of ISO 2553.")
    throat_mm: Maybe[Annotated[float, Meta(gt=0, le=100)] | None] = D(
        "Throat of a fillet, a of ISO 2553; instead of leg_mm."
    )
    leg_mm: Maybe[Annotated[float, Meta(gt=0, le=100)] | None] = D("Fillet leg, z of ISO 2553; instead of throat_mm.")
    depth_mm: Maybe[Annotated[float, Meta(gt=0, le=1000)] | None] = D(
        "Depth of a butt weld from its face to its root, s of ISO 2553."
    )
    root_gap_mm: Maybe[Annotated[float, Meta(ge=0, le=100)] | None] = D("b of ISO 2553.")
    root_face_mm: Maybe[Annotated[float, Meta(ge=0, le=1000)] | None] = D("c of ISO 2553.")
    groove_angle_deg: Maybe[Annotated[float, Meta(ge=0, le=150)] | None] = D("Between both sides of the groove.")
    process: Maybe[Annotated[str, Meta(pattern="^[0-9]{2,3}$")] | None] = D("Number of ISO 4063; 135: MAG, solid wire.")
    wire_mm: Maybe[Annotated[float, Meta(ge=0.4, le=6)] | None] = D("Diameter of the wire.")
    passes: Maybe[Annotated[int, Meta(ge=1, le=200)] | None] = D("Number of beads.")
    job: Maybe[Annotated[int, Meta(ge=0, le=9999)] | None] = D(
        "Job of the power source, or number of the schedule or of the file of conditions in the controller."
    )
    seam_data: Maybe[Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9_]{0,31}$")] | None] = D(
        "Name of data in the controller for ignition and end."
    )
    weld_data: Maybe[Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9_]{0,31}$")] | None] = D(
        "Name of data in the controller for the weld."
    )
    weave_data: Maybe[Annotated[str, Meta(pattern="^[A-Za-z0-9][A-Za-z0-9_]{0,31}$")] | None] = D(
        "Name of data in the controller for the weave, or the number of its file or schedule."
    )
    current_a: Maybe[Annotated[float, Meta(gt=0, le=2000)] | None] = D("Of every bead.")
    voltage_v: Maybe[Annotated[float, Meta(gt=0, le=100)] | None] = D("Of every bead.")
    wire_feed_m_min: Maybe[Annotated[float, Meta(gt=0, le=100)] | None] = D("Of every bead.")
    speed_mm_s: Maybe[Annotated[float, Meta(gt=0, le=500)] | None] = D("Along the seam.")
    stick_out_mm: Maybe[Annotated[float, Meta(ge=0, le=100)] | None] = D(
        "Free wire from the contact tip to the seam, for which the tool centre point is taught."
    )
    work_angle_deg: Maybe[Annotated[float, Meta(ge=-60, le=60)] | None] = D(
        "Of the torch, from the bisector, positive towards y."
    )
    travel_angle_deg: Maybe[Annotated[float, Meta(ge=-45, le=45)] | None] = D("Of the torch, positive is push.")
    start_delay_s: Maybe[Annotated[float, Meta(ge=0, le=100)] | None] = D("The arc burns before the torch moves.")
    end_delay_s: Maybe[Annotated[float, Meta(ge=0, le=100)] | None] = D("The arc burns after the torch has stopped.")
    weave: Maybe[Weave | None]
    crater: Maybe[Crater | None]
    stitch: Maybe[Stitch | None] = D("Null: the whole seam is welded.")
    tacks: Maybe[Stitch | None] = D("Tack welds.")


class Origin(Record, rename={"from_": "from"}):
    from_: Literal["rule", "file", "model", "user"]
    of: Maybe[str] = D("The rule or the file.")
    given: Any = D("The value as it came. If `values` holds another one, the user stated it.")


class Bead(Record):
    number: Number
    layer: Number
    y_mm: float = D("Where the wire points.")
    z_mm: float = D("Where the wire points.")
    area_mm2: NotNegative
    work_angle_deg: float = D("Added to that of the weld.")
    outline_mm: list[Pair] = D("Corners of the section.")


class Weld(Record):
    name: Text = D("Of the seam.")
    words: Maybe[str] = D("The weld in words of ISO 2553; for reading only.")
    joint: Maybe[Literal["tee", "lap", "butt", "corner", "edge", "unknown"]] = D("For reading only.")
    place: Maybe[Place]
    values: Maybe[Values]
    given_back: Maybe[list[str]] = D(
        "Names of values that go back to the rules: of the page of wpcal welds --html, for --values."
    )
    origin: Maybe[dict[str, Origin]] = D("By the name of a value: where it came from.")
    beads: Maybe[list[Bead]] = D("In the order of welding, in y and z of the seam frame; computed.")
    stretches_mm: Maybe[list[Pair]] = D("Welded stretches, lengths from the start of the seam; computed.")
    tacks_mm: Maybe[list[Pair]] = D("Tack welds, lengths from the start of the seam; computed.")


class WithoutSeam(Record):
    name: Text
    place: Maybe[Place]
    values: Values


class Welds(Record):
    """wpcal welds, version 1

    What is laid into every seam (welds.json), edited by hand.
    """

    schema: Literal["wpcal/welds/1"]
    units: Maybe[Units]
    rules: Maybe[str] = D("The table of rules: wpcal, or the file of the user.")
    welds: list[Weld]
    without_seam: Maybe[list[WithoutSeam]] = D("Values of the user for seams that are not there.")
    notes: Maybe[list[str]] = D("What is not obvious (wpcal welds --json).")


class Rule(Record):
    name: Text
    source: Text = D("Where the values come from, or the reason for them.")
    joint: Maybe[list[Literal["tee", "lap", "butt", "corner", "edge", "unknown"]]]
    weld: Maybe[list[Literal["fillet", "groove", "flare-bevel groove", "flare-V groove", "unknown"]]]
    position: Maybe[list[Literal["PA", "PB", "PC", "PD", "PE", "PF", "PG"]]]
    thickness_mm: Maybe[Annotated[list[Annotated[float, Meta(ge=0, le=1000)]], Meta(min_length=2, max_length=2)]] = D(
        "Of the thinner plate: above the first and up to the second."
    )
    values: Maybe[Values]
    bead_mm2: Maybe[Annotated[float, Meta(gt=0, le=10000)]] = D("Section of the bead for which the speed holds.")
    most_bead_mm2: Maybe[Annotated[float, Meta(gt=0, le=10000)]] = D("Largest section of one bead.")


class WeldRules(Record):
    """wpcal weld rules, version 1

    Weld data by joint, thickness and position (a TOML file).
    """

    schema: Literal["wpcal/weld-rules/1"]
    rules: list[Rule]
