"""Wrong STEP files that still look right: references exchanged, entities removed or doubled, sizes that are none.

Most of them pass the reader of the text, and many the kernel. They reach the code that judges what the kernel built.
"""

import random
import re
from collections.abc import Callable

ENTITY = re.compile(rb"#(\d+)[ \t]*=[ \t\r\n]*(\w*)[^;]*;")
REFERENCE = re.compile(rb"#(\d+)")
REAL = re.compile(rb"[-+]?\d+\.\d*(?:[eE][-+]?\d+)?")
GEOMETRY = re.compile(
    rb"SURFACE|CIRCLE|ELLIPSE|B_SPLINE|BEZIER|LINE|VECTOR|AXIS|POINT|DIRECTION|PLACEMENT|CONTEXT|UNIT"
)
SIZED = re.compile(
    rb"CIRCLE|ELLIPSE|CYLIND|CONICAL|SPHERICAL|TOROIDAL|VECTOR|B_SPLINE|OFFSET|UNCERTAINTY|LENGTH|PLANE_ANGLE"
)
HUGE = (b"1.E400", b"1.E308", b"-1.E300", b"1.E30", b"1.E15", b"1.E9", b"-1.E7")
TINY = (b"0.", b"-0.", b"1.E-320", b"1.E-12", b"-1.E-7", b"1.E-3")
WORDS = (b"NAN.", b"$", b"*", b".T.", b"1", b"''", b"()", b"#0", b"#99999999", b"INF")
FACTORS = (-1.0, 0.5, 2.0, 1.0001, 1e-3, 1e3, 1e6)


def mutated_step(data: bytes, rng: random.Random) -> bytes:
    """Return a changed copy of a STEP file. Its text stays a list of entities."""
    head, mark, body = data.partition(b"DATA;")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        entities = list(ENTITY.finditer(body))
        if not entities:
            return data
        body = rng.choice(CHANGES)(body, entities, rng)
    return head + mark + body


Entities = list["re.Match[bytes]"]


def _replaced(body: bytes, start: int, end: int, by: bytes) -> bytes:
    return body[:start] + by + body[end:]


def _one_of(entities: Entities, rng: random.Random, kind: re.Pattern[bytes] | None = None) -> re.Match[bytes]:
    fitting = entities if kind is None else [one for one in entities if kind.search(one[0])]
    return rng.choice(fitting or entities)


def _refer(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Let an entity refer to another of the same kind, sometimes of any kind."""
    one = _one_of(entities, rng)
    found = list(REFERENCE.finditer(body, one.start() + 1, one.end()))
    if not found:
        return body
    reference = rng.choice(found)
    kinds = {entity[1]: entity[2] for entity in entities}
    like = [number for number, kind in kinds.items() if kind == kinds.get(reference[1])]
    number = rng.choice(like if like and rng.random() < 0.8 else list(kinds))
    return _replaced(body, *reference.span(1), number)


def _remove(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    return _replaced(body, *_one_of(entities, rng).span(), b"")


def _shorten(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Take one reference out of a list, for example a face out of a shell."""
    one = _one_of(entities, rng)
    found = list(re.finditer(rb"#\d+,|,#\d+(?=\))", body[one.start() + 1 : one.end()]))
    if not found:
        return body
    piece = rng.choice(found)
    return _replaced(body, one.start() + 1 + piece.start(), one.start() + 1 + piece.end(), b"")


def _double(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Give an entity the number of another."""
    one, other = _one_of(entities, rng), _one_of(entities, rng)
    return body[: other.start()] + one[0].replace(one[1], other[1], 1) + b"\n" + body[other.start() :]


def _exchange(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Exchange what two entities of one kind say."""
    one = _one_of(entities, rng)
    other = rng.choice([entity for entity in entities if entity[2] == one[2]])
    first, second = sorted((one, other), key=lambda entity: entity.start())
    if first.start() == second.start():
        return body
    a, b = (entity[0].partition(b"=")[2] for entity in (first, second))
    later = _replaced(body, second.end() - len(b), second.end(), a)
    return _replaced(later, first.end() - len(a), first.end(), b)


def _size(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Change a radius, a length or a weight."""
    return _number_of(body, _one_of(entities, rng, SIZED), rng)


def _number(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    return _number_of(body, _one_of(entities, rng, GEOMETRY), rng)


def _number_of(body: bytes, one: re.Match[bytes], rng: random.Random) -> bytes:
    found = list(REAL.finditer(body, one.start(), one.end()))
    if not found:
        return body
    number = rng.choice(found)
    way = rng.random()
    if way < 0.6:
        value = float(number[0]) * rng.choice(FACTORS) + rng.choice((0.0, 0.0, 0.01, 1.0, -20.0))
        return _replaced(
            body, *number.span(), f"{value:.9G}".replace("INF", "1.E400").encode() + b"." * (value % 1 == 0)
        )
    return _replaced(body, *number.span(), rng.choice(HUGE if way < 0.75 else TINY if way < 0.92 else WORDS))


def _null_vector(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    one = _one_of(entities, rng, re.compile(rb"=\s*DIRECTION"))
    values = rng.choice((b"0.,0.,0.", b"1.,0.,0.", b"0.,0.,1.", b"0.,0.", b"-1.,0.,0.", b"1.E200,1.E200,0."))
    return _replaced(body, *one.span(), re.sub(rb"\(([-+\d.eE, \r\n]+)\)", b"(" + values + b")", one[0], count=1))


def _flag(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Turn a face, an edge or a curve round."""
    found = list(re.finditer(rb"\.([TF])\.", body))
    if not found:
        return body
    one = rng.choice(found)
    return _replaced(body, *one.span(1), b"F" if one[1] == b"T" else b"T")


def _whole_number(body: bytes, entities: Entities, rng: random.Random) -> bytes:
    """Change a degree, a multiplicity or a count."""
    one = _one_of(entities, rng, re.compile(rb"B_SPLINE|KNOT|DIMENSION"))
    found = list(re.finditer(rb"(?<=[,(])\d+(?=[,)])", body[one.start() : one.end()]))
    if not found:
        return body
    number = rng.choice(found)
    by = rng.choice((b"0", b"1", b"2", b"3", b"7", b"30", b"-1", b"100000", b"9999999999"))
    return _replaced(body, one.start() + number.start(), one.start() + number.end(), by)


CHANGES: tuple[Callable[[bytes, Entities, random.Random], bytes], ...] = (
    _refer, _refer, _refer, _remove, _shorten, _double, _exchange, _exchange, _size, _size, _number, _number, _number,
    _null_vector, _flag, _whole_number,
)  # fmt: skip
