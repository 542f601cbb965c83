"""What records are made of: the base of their types, and kinds of values that many of them have."""

from typing import Annotated, Any, Literal, TypeVar, Union

from msgspec import Meta, Struct, StructMeta, UnsetType
from msgspec.json import schema_components

T = TypeVar("T")
Maybe = Union[T, UnsetType]  # noqa: UP007  # mypy takes no | with a type variable in an alias
"""A field that a record may lack."""


class _Keywords(StructMeta):
    """Lets required fields follow those that may be missing."""

    def __new__(cls, *arguments: Any, **settings: Any) -> Any:
        return super().__new__(cls, *arguments, **{"kw_only": True, **settings})


class Record(Struct, metaclass=_Keywords, forbid_unknown_fields=True):
    """An object with these fields only."""


class Open(Struct, metaclass=_Keywords):
    """An object that may have other fields, too."""


def D(text: str) -> Meta:
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
Covariance = Annotated[list[Six], Meta(min_length=6, max_length=6)]


class Issue(Record):
    """Something odd, but not fatal."""

    code: Annotated[
        Annotated[str, Meta(pattern="^[a-z0-9]+(-[a-z0-9]+)*$")], D("Stable word for programs, lower case with dashes.")
    ]
    message: Annotated[str, D("One sentence for people.")]
    ids: Annotated[list[str], D("Names of the faces, solids, points or seams concerned.")]


class Neck(Record):
    angle_deg: Annotated[Annotated[float, Meta(ge=0, le=180)], D("By how much the neck bends away from the wire.")]
    from_mm: Annotated[NotNegative, D("From the mouth of the nozzle to where the bend begins.")]
    bend_mm: Annotated[NotNegative, D("Radius of the centre line of the bend.")]
    radius_mm: Annotated[NotNegative, D("Outer radius of the neck.")]
    body_from_mm: Annotated[NotNegative, D("From the mouth along the centre line to where the body begins.")]
    body_radius_mm: Annotated[NotNegative, D("Outer radius of the body.")]


class Member(Record):
    solid: str
    taken_as: Annotated[str, D("steel, a bolt or screw, wood, …")]
    factor: Annotated[Share, D("The confidence of each of its seams was multiplied by it; 1 for a member.")]
    why: Annotated[list[str], D("The evidence in words.")]
    said: Annotated[bool | None, D("Whether a person said that it can be welded; null if nobody said anything.")]


class Units(Record):
    length: Literal["mm"]
    angle: Literal["deg"]
