"""Records: welds, weld-rules."""

from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta

from wpcal.records.parts import D, Maybe, NotNegative, Number, Pair, Record, Text, Vector
from wpcal.records.plans import Units


class Place(Record):
    """By which the seam is recognised under another name, in coordinates of the part."""

    start_part_mm: Vector
    middle_part_mm: Vector
    length_mm: NotNegative


class Weave(Record):
    shape: Literal["zigzag", "sine", "triangle", "circle"]
    width_mm: Annotated[Annotated[float, Meta(gt=0, le=100)], D("From side to side.")]
    length_mm: Annotated[Annotated[float, Meta(gt=0, le=1000)], D("Along the seam, per swing to and fro.")]
    dwell_left_s: Maybe[Annotated[Annotated[float, Meta(ge=0, le=100)], D("Pause at the side of +y.")]] = UNSET
    dwell_right_s: Maybe[Annotated[Annotated[float, Meta(ge=0, le=100)], D("Pause at the side of -y.")]] = UNSET


class Crater(Record):
    time_s: Annotated[float, Meta(ge=0, le=100)]
    current_a: Maybe[Annotated[Annotated[float, Meta(gt=0, le=2000)], D("Without it that of the weld.")]] = UNSET
    voltage_v: Maybe[Annotated[Annotated[float, Meta(gt=0, le=100)], D("Without it that of the weld.")]] = UNSET


class Stitch(Record):
    length_mm: Annotated[Annotated[float, Meta(gt=0, le=100000)], D("Of each stretch.")]
    pitch_mm: Annotated[
        Annotated[float, Meta(gt=0, le=100000)], D("From the start of a stretch to the start of the next.")
    ]
    offset_mm: Maybe[
        Annotated[
            Annotated[float, Meta(ge=0, le=100000)] | None,
            D(
                "From the start of the seam to the first stretch; null or missing: the same length is left free "
                "at both ends."
            ),
        ]
    ] = UNSET


class Values(Record):
    """What is welded.

    Change a value to state it; delete it to get that of the rules; null states that there
    is none.
    """

    thickness_mm: Maybe[Annotated[Annotated[float, Meta(gt=0, le=1000)] | None, D("Of the thinner plate.")]] = UNSET
    position: Maybe[
        Annotated[Literal["PA", "PB", "PC", "PD", "PE", "PF", "PG"] | None, D("Weld position of ISO 6947.")]
    ] = UNSET
    weld: Maybe[
        Annotated[
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
            | None,
            D("In words of ISO 2553."),
        ]
    ] = UNSET
    throat_mm: Maybe[
        Annotated[
            Annotated[float, Meta(gt=0, le=100)] | None, D("Throat of a fillet, a of ISO 2553; instead of leg_mm.")
        ]
    ] = UNSET
    leg_mm: Maybe[
        Annotated[
            Annotated[float, Meta(gt=0, le=100)] | None, D("Leg of a fillet, z of ISO 2553; instead of throat_mm.")
        ]
    ] = UNSET
    depth_mm: Maybe[
        Annotated[
            Annotated[float, Meta(gt=0, le=1000)] | None,
            D("Depth of a butt weld from its face to its root, s of ISO 2553."),
        ]
    ] = UNSET
    root_gap_mm: Maybe[Annotated[Annotated[float, Meta(ge=0, le=100)] | None, D("b of ISO 2553.")]] = UNSET
    root_face_mm: Maybe[Annotated[Annotated[float, Meta(ge=0, le=1000)] | None, D("c of ISO 2553.")]] = UNSET
    groove_angle_deg: Maybe[
        Annotated[Annotated[float, Meta(ge=0, le=150)] | None, D("Between both sides of the groove.")]
    ] = UNSET
    process: Maybe[
        Annotated[
            Annotated[str, Meta(pattern="^[0-9]{2,3}$")] | None, D("Number of ISO 4063: 135 is MAG with solid wire.")
        ]
    ] = UNSET
    wire_mm: Maybe[Annotated[Annotated[float, Meta(ge=0.4, le=6)] | None, D("Diameter of the wire.")]] = UNSET
    passes: Maybe[Annotated[Annotated[int, Meta(ge=1, le=200)] | None, D("Number of beads.")]] = UNSET
    job: Maybe[
        Annotated[
            Annotated[int, Meta(ge=0, le=9999)] | None,
            D("Job of the power source, or number of the schedule or of the file of conditions in the controller."),
        ]
    ] = UNSET
    seam_data: Maybe[
        Annotated[
            Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9_]{0,31}$")] | None,
            D("Name of data in the controller for ignition and end."),
        ]
    ] = UNSET
    weld_data: Maybe[
        Annotated[
            Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9_]{0,31}$")] | None,
            D("Name of data in the controller for the weld."),
        ]
    ] = UNSET
    weave_data: Maybe[
        Annotated[
            Annotated[str, Meta(pattern="^[A-Za-z0-9][A-Za-z0-9_]{0,31}$")] | None,
            D("Name of data in the controller for the weave, or the number of its file or schedule."),
        ]
    ] = UNSET
    current_a: Maybe[Annotated[Annotated[float, Meta(gt=0, le=2000)] | None, D("Of every bead.")]] = UNSET
    voltage_v: Maybe[Annotated[Annotated[float, Meta(gt=0, le=100)] | None, D("Of every bead.")]] = UNSET
    wire_feed_m_min: Maybe[Annotated[Annotated[float, Meta(gt=0, le=100)] | None, D("Of every bead.")]] = UNSET
    speed_mm_s: Maybe[Annotated[Annotated[float, Meta(gt=0, le=500)] | None, D("Along the seam.")]] = UNSET
    stick_out_mm: Maybe[
        Annotated[
            Annotated[float, Meta(ge=0, le=100)] | None,
            D("Free wire from the contact tip to the seam, for which the tool centre point is taught."),
        ]
    ] = UNSET
    work_angle_deg: Maybe[
        Annotated[
            Annotated[float, Meta(ge=-60, le=60)] | None, D("Of the torch, from the bisector, positive towards y.")
        ]
    ] = UNSET
    travel_angle_deg: Maybe[
        Annotated[Annotated[float, Meta(ge=-45, le=45)] | None, D("Of the torch, positive is push.")]
    ] = UNSET
    start_delay_s: Maybe[
        Annotated[Annotated[float, Meta(ge=0, le=100)] | None, D("The arc burns before the torch moves.")]
    ] = UNSET
    end_delay_s: Maybe[
        Annotated[Annotated[float, Meta(ge=0, le=100)] | None, D("The arc burns after the torch has stopped.")]
    ] = UNSET
    weave: Maybe[Weave | None] = UNSET
    crater: Maybe[Crater | None] = UNSET
    stitch: Maybe[Annotated[Stitch | None, D("Null: the whole seam is welded.")]] = UNSET
    tacks: Maybe[Annotated[Stitch | None, D("Tack welds.")]] = UNSET


class Origin(Record, rename={"from_": "from"}):
    from_: Literal["rule", "file", "model", "user"]
    of: Maybe[Annotated[str, D("The rule or the file.")]] = UNSET
    given: Annotated[Any, D("The value as it came. If `values` holds another one, the user stated it.")]


class Bead(Record):
    number: Number
    layer: Number
    y_mm: Annotated[float, D("Where the wire points.")]
    z_mm: Annotated[float, D("Where the wire points.")]
    area_mm2: NotNegative
    work_angle_deg: Annotated[float, D("Added to that of the weld.")]
    outline_mm: Annotated[list[Pair], D("Corners of the section.")]


class Weld(Record):
    name: Annotated[Text, D("Of the seam.")]
    words: Maybe[Annotated[str, D("The weld in words of ISO 2553; for reading only.")]] = UNSET
    joint: Maybe[Annotated[Literal["tee", "lap", "butt", "corner", "edge", "unknown"], D("For reading only.")]] = UNSET
    place: Maybe[Place] = UNSET
    values: Maybe[Values] = UNSET
    given_back: Maybe[
        Annotated[
            list[str], D("Names of values that go back to the rules: of the page of wpcal welds --html, for --values.")
        ]
    ] = UNSET
    origin: Maybe[Annotated[dict[str, Origin], D("By the name of a value: where it came from.")]] = UNSET
    beads: Maybe[Annotated[list[Bead], D("In the order of welding, in y and z of the seam frame; computed.")]] = UNSET
    stretches_mm: Maybe[Annotated[list[Pair], D("Welded stretches, lengths from the start of the seam; computed.")]] = (
        UNSET
    )
    tacks_mm: Maybe[Annotated[list[Pair], D("Tack welds, lengths from the start of the seam; computed.")]] = UNSET


class WithoutSeam(Record):
    name: Text
    place: Maybe[Place] = UNSET
    values: Values


class Welds(Record):
    """wpcal welds, version 1

    What is laid into every seam (welds.json), edited by hand.
    """

    schema: Literal["wpcal/welds/1"]
    units: Maybe[Units] = UNSET
    rules: Maybe[Annotated[str, D("The table of rules: wpcal, or the file of the user.")]] = UNSET
    welds: list[Weld]
    without_seam: Maybe[Annotated[list[WithoutSeam], D("Values of the user for seams that are not there.")]] = UNSET
    notes: Maybe[Annotated[list[str], D("What is not obvious (wpcal welds --json).")]] = UNSET


class Rule(Record):
    name: Text
    source: Annotated[Text, D("Where the values come from, or the reason for them.")]
    joint: Maybe[list[Literal["tee", "lap", "butt", "corner", "edge", "unknown"]]] = UNSET
    weld: Maybe[list[Literal["fillet", "groove", "flare-bevel groove", "flare-V groove", "unknown"]]] = UNSET
    position: Maybe[list[Literal["PA", "PB", "PC", "PD", "PE", "PF", "PG"]]] = UNSET
    thickness_mm: Maybe[
        Annotated[
            Annotated[list[Annotated[float, Meta(ge=0, le=1000)]], Meta(min_length=2, max_length=2)],
            D("Of the thinner plate: above the first and up to the second."),
        ]
    ] = UNSET
    values: Maybe[Values] = UNSET
    bead_mm2: Maybe[
        Annotated[Annotated[float, Meta(gt=0, le=10000)], D("Section of the bead for which the speed holds.")]
    ] = UNSET
    most_bead_mm2: Maybe[Annotated[Annotated[float, Meta(gt=0, le=10000)], D("Largest section of one bead.")]] = UNSET


class WeldRules(Record):
    """wpcal weld rules, version 1

    Weld data by joint, thickness and position (a TOML file).
    """

    schema: Literal["wpcal/weld-rules/1"]
    rules: list[Rule]
