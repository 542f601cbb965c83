"""Wrong inputs from right ones: bytes, lines, numbers and JSON values are changed, pieces are repeated."""

import copy
import json
import random
import re
from collections.abc import Callable, Sequence
from typing import Any

NASTY = (
    b"nan", b"-inf", b"Infinity", b"1e400", b"1e308", b"-1e300", b"1e9", b"1.0000001e9", b"81_2", b"0x1F", b"1,5",
    b"1.234,5", b"1,234.5", b"1 234.5", b"812.3 mm", b"0.8 m", b"-0", b"00", b".", b"-", b"+", b"e5", b"1e", b"1.5",
    "１２".encode(), "\u2212 5".encode(), b"", b" ", b"true", b"null", b"9" * 400, b"9" * 5000, b"1" + b"0" * 30,
    b"4294967296", b"18446744073709551616", b"-1", b"2", b"1e-320", b"\x00", b"\xff", b"\xef\xbb\xbf", b"\x1b[31m",
    b"\\ud800", b"\r", b"\n", b"\t", b";", b",", b"'", b'"', b"[", b"]", b"{", b"}", b"(", b")", b"/*", b"*/", b"#1",
    b"#99999999999999999999", b"\\X2\\D800\\X0\\", b"$", b"*", b"=", b"#", b"!", b"<!ENTITY a 'b'>", b"&a;",
)  # fmt: skip
NASTY_JSON: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 1.5, 1e9, -1e12, 1e300, float("nan"), float("inf"), 10**400, "", "x", "1", "\ud800",
    "\x1b[31m", [], {}, [[]], [1], [None], {"": 1}, [1, 2, 3], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "W1", "base", "yes",
)  # fmt: skip
NUMBER = re.compile(rb"[-+]?[0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?")
MOST_REPEATS = 300
LARGEST_BYTES = 400_000


def mutated(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    """Return a changed copy of an input.

    `others`: More inputs, of which pieces are taken.
    """
    if data[:1] == b"{" and rng.random() < 0.7:
        return _mutated_json(data, rng)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        data = rng.choice(CHANGES)(data, others, rng)
    return data[:LARGEST_BYTES]


def _place(data: bytes, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + rng.choice((1, 1, 2, 4, 8, 30, 200)))


def _flip(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    start, _end = _place(data, rng)
    return data[:start] + bytes([rng.randrange(256)]) + data[start + 1 :]


def _insert(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    start, _end = _place(data, rng)
    return data[:start] + rng.choice(NASTY) + data[start:]


def _delete(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    start, end = _place(data, rng)
    return data[:start] + data[end:]


def _cut(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    return data[: _place(data, rng)[0]]


def _number(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    one = rng.choice(found)
    return data[: one.start()] + rng.choice(NASTY) + data[one.end() :]


def _repeat(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    start, end = _place(data, rng)
    return data[:start] + data[start:end] * rng.randrange(2, MOST_REPEATS) + data[end:]


def _move_line(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    line = lines.pop(rng.randrange(len(lines)))
    for _copy in range(rng.choice((0, 1, 2))):
        lines.insert(rng.randrange(len(lines) + 1), line)
    return b"".join(lines)


def _cells(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    """Exchange two pieces between separators."""
    pieces = re.split(rb"([,;\t\n])", data)
    if len(pieces) < 3:
        return data
    a, b = (2 * rng.randrange((len(pieces) + 1) // 2) for _ in range(2))
    pieces[a], pieces[b] = pieces[b], rng.choice((pieces[a], b""))
    return b"".join(pieces)


def _splice(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    other = rng.choice(others)
    return data[: _place(data, rng)[0]] + other[_place(other, rng)[0] :]


CHANGES: tuple[Callable[[bytes, Sequence[bytes], random.Random], bytes], ...] = (
    _flip, _insert, _insert, _delete, _cut, _number, _number, _number, _repeat, _move_line, _cells, _cells, _splice,
)  # fmt: skip


def _mutated_json(data: bytes, rng: random.Random) -> bytes:
    """Exchange, remove or add values of a JSON record."""
    try:
        record = json.loads(data)
    except ValueError:
        return _insert(data, (), rng)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        owners = _owners(record)
        owner = rng.choice(owners) if owners else record
        keys = list(owner) if isinstance(owner, dict) else list(range(len(owner)))
        if not keys:
            continue
        key = rng.choice(keys)
        change = rng.randrange(6)
        if change == 0 and key != "schema":
            del owner[key]
        elif change == 1:
            value = owner[rng.choice(keys)]
            text = json.dumps(value)
            if len(text) < len(data) // 4:
                owner[key] = json.loads(text)
        elif change == 2 and isinstance(owner[key], int | float) and not isinstance(owner[key], bool):
            owner[key] = min(max(owner[key], -1e300), 1e300) * rng.choice((0, -1, 1e3, 1e9, 1e-9, 1.0001))
        elif key != "schema":
            owner[key] = copy.deepcopy(rng.choice(NASTY_JSON))
    return json.dumps(record).encode("utf-8")[:LARGEST_BYTES]


def _owners(record: Any) -> list[Any]:
    found, stack = [], [record]
    while stack:
        value = stack.pop()
        if isinstance(value, dict | list):
            found.append(value)
            stack.extend(value.values() if isinstance(value, dict) else value)
    return found
