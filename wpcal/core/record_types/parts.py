"""What records are made of: the base of their types, and kinds of values that many of them have."""

from typing import Annotated, Any, Literal, TypeVar, Union, get_args

from msgspec import UNSET, Meta, Struct, StructMeta, UnsetType
from msgspec.json import schema_components

T = TypeVar("T")
Maybe = Union[T, UnsetType]  # noqa: UP007  # mypy takes no | with a type variable in an alias
"""A field that a record may lack."""


class _Fields(StructMeta):
    """Makes fields of what a class says: ``name: kind``, with what it is after ``= D(…)``; `Maybe` kinds may lack."""

    def __new__(cls, name: str, bases: tuple[type, ...], space: dict[str, Any], **settings: Any) -> Any:
        kinds = space.get("__annotations__", {})
        for field, kind in kinds.items():
            said, inner = space.pop(field, None), [each for each in get_args(kind) if each is not UnsetType]
            may_lack = len(inner) < len(get_args(kind))
            if isinstance(said, Meta):
                kinds[field] = Annotated[Union[tuple(inner)] if may_lack else kind, said]  # noqa: UP007
                kinds[field] = kinds[field] | UnsetType if may_lack else kinds[field]
            if may_lack:
                space[field] = UNSET
        return super().__new__(cls, name, bases, space, **{"kw_only": True, **settings})


class Record(Struct, metaclass=_Fields, forbid_unknown_fields=True):
    """An object with these fields only."""


class Open(Struct, metaclass=_Fields):
    """An object that may have other fields, too."""


def D(text: str) -> Any:
    """Say what a field is."""
    return Meta(description=text)


def inlined(*kinds: type[Struct]) -> list[dict[str, Any]]:
    """Return the schemas of some kinds of object without references."""
    schemas, parts = schema_components(kinds, ref_template="#/$defs/{name}")

    def whole(node: Any) -> Any:
        if isinstance(node, list):
            return [whole(each) for each in node]
        if not isinstance(node, dict):
            return node
        found = parts[node["$ref"].removeprefix("#/$defs/")] if "$ref" in node else node
        return {key: whole(each) for key, each in found.items() if key != "title" or not isinstance(each, str)}

    return [whole(each) for each in schemas]


def one_of(*kinds: type[Struct]) -> Meta:
    """Say which kinds of object a field may hold (msgspec tells unions of objects apart by a tag only)."""
    return Meta(extra_json_schema={"anyOf": inlined(*kinds)})


NotNegative = Annotated[float, Meta(ge=0)]
Positive = Annotated[float, Meta(gt=0)]
Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=0)]
Number = Annotated[int, Meta(ge=1)]
Text = Annotated[str, Meta(min_length=1)]
Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Pair = Annotated[list[float], Meta(min_length=2, max_length=2)]
Vector = Annotated[list[float], Meta(min_length=3, max_length=3)]
Quaternion = Annotated[list[float], Meta(min_length=4, max_length=4)]
Six = Annotated[list[float], Meta(min_length=6, max_length=6)]
Rotation = Annotated[list[Vector], Meta(min_length=3, max_length=3)]
Matrix = Annotated[list[Quaternion], Meta(min_length=4, max_length=4)]
MatrixByRows = Annotated[
    Matrix, D("Homogeneous 4×4 matrix by rows: rotation without unit, translation in mm; the last row is 0 0 0 1.")
]
Space = Annotated[
    Literal["nominal", "identified"], D("Robot model behind the positions: the controller's own, or an identified one.")
]
Covariance = Annotated[list[Six], Meta(min_length=6, max_length=6)]


class Issue(Record):
    """Something odd, but not fatal."""

    code: Annotated[str, Meta(pattern="^[a-z0-9]+(-[a-z0-9]+)*$")] = D("Stable word for programs: lower case, dashes.")
    message: str = D("One sentence for people.")
    ids: list[str] = D("Names of the faces, solids, points or seams concerned.")


class Neck(Record):
    angle_deg: Annotated[float, Meta(ge=0, le=180)] = D("By how much the neck bends away from the wire.")
    from_mm: NotNegative = D("From the mouth of the nozzle to where the bend begins.")
    bend_mm: NotNegative = D("Radius of the centre line of the bend.")
    radius_mm: NotNegative = D("Outer radius of the neck.")
    body_from_mm: NotNegative = D("From the mouth along the centre line to where the body begins.")
    body_radius_mm: NotNegative = D("Outer radius of the body.")


class TorchShape(Record):
    wire_mm: NotNegative = D("From the tip of the wire to the mouth of the nozzle.")
    nozzle_radius_mm: NotNegative = D("Outer radius of the nozzle.")
    length_mm: NotNegative = D("From the tip of the wire along the centre line to where the wrist has room to turn.")
    name: Maybe[str] = D("Name of a shipped torch or of a torch file; stated: sizes given by a program.")
    mouth_radius_mm: Maybe[NotNegative] = D("Outer radius at the mouth of a conical nozzle. Missing: cylindrical.")
    taper_mm: Maybe[NotNegative] = D("Length of the cone of the nozzle.")
    most_wire_mm: Maybe[NotNegative] = D("The longest wire with which the torch still welds. Missing: wire_mm.")
    neck: Maybe[Neck] = D("What is behind the nozzle. Missing: the torch is straight.")


class ToolError(Record):
    side_mm: NotNegative = D("Standard deviation per axis sideways.")
    along_mm: NotNegative = D("Standard deviation along the wire, with its stick-out.")


class ListedMember(Record):
    name: str = D("That of the solid, or of one of its members: frame/2.")
    kind: str = D("Bought or cut as: plate 10 mm. Empty for a solid of several members, or of none.")
    thickness_mm: NotNegative
    length_mm: NotNegative
    density_kg_m3: NotNegative = D("As the file states it, or that of its metal; steel if nothing is known.")
    mass_kg: float = D("The members of a solid together weigh what the solid does; the share of each is an estimate.")
    weld_mm: NotNegative = D("Length of the accepted seams on it.")
    seams: list[str] = D("Their names.")


class Member(Record):
    solid: str
    taken_as: str = D("steel, a bolt or screw, wood, …")
    factor: Share = D("The score of each of its seams was multiplied by it; 1 for a member.")
    why: list[str] = D("The evidence in words.")
    said: bool | None = D("Whether a person said that it can be welded; null if nobody said anything.")
    listed: Maybe[list[ListedMember]] = D("The solid, then its members if it was several (wpcal seams --json).")


class Place(Record):
    """Translation in mm and angles in degrees, R = Rz(yaw) Ry(pitch) Rx(roll)."""

    xyz_mm: Vector
    rpy_deg: Vector = D("Roll, pitch, yaw.")


class Units(Record):
    length: Literal["mm"]
    angle: Literal["deg"]


class FeatureOfPart(Record):
    name: str = D("Letter of the kind and a number, for example H1.")
    kind: Literal[
        "vertex",
        "circle",
        "hole",
        "sphere",
        "edge_midpoint",
        "boss",
        "slot",
        "virtual_corner",
        "edge_end",
        "plane",
        "axis",
    ]
    p_mm: Annotated[Vector, D("x, y, z in mm.")] = D("The point; the centre of a circle, hole or sphere. In part.")
    direction: Annotated[Vector, D("Unit vector.")] | None = D("Axis or normal in part; null if the kind has none.")
    diameter_mm: NotNegative | None = D("Of a slot: its width. Null if the kind has none.")
    solid: str = D("Name of the solid.")
    touch: Literal["tip in corner", "tip on edge", "rim", "wall", "face", "its three faces"] = D("How it is touched.")
    faces: list[Count] = D("Faces that are touched, by their number in the part.")
    length_mm: Maybe[NotNegative] = D("Of an edge, boss, slot or axis.")
    depth_mm: Maybe[NotNegative] = D("Of a hole or slot.")
    area_mm2: Maybe[NotNegative] = D("Of a plane.")
    is_through: Maybe[bool] = D("Of a hole or slot: open at both ends.")
    form: Maybe[Literal["plain", "countersink", "counterbore"]] = D("Of a hole.")
    steps: Maybe[list[Vector]] = D("Diameters of a hole from its entry: diameter, begin and end of the depth, mm.")
