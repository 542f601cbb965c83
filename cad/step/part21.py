"""The text of a STEP file (ISO 10303-21): where every statement begins and ends.

Words: a *statement* ends with a semicolon outside strings and comments. An *instance* is a statement ``#12=…;``. A
*record* is one ``KEYWORD(arguments)``. A complex instance holds several records in one pair of brackets.

The text is never changed. It is indexed once, with array operations over its bytes. Only the instances asked for are
parsed.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cad.step.part21_values import MOST_DIGITS, Instance, StepRecord, Value, parse_instance, parse_value
from wpcal.core.arrays import IntArray
from wpcal.core.errors import FormatError
from wpcal.core.wording import shown

_QUOTE, _SEMICOLON, _HASH, _ZERO = b"';#0"
_NOT_BLANK = re.compile(rb"[^\x00-\x20]")
_LARGE_EXPONENT = re.compile(rb"[eE](?<=[0-9.].)\+?[0-9]{3,9}")
_LAST_DIGITS = re.compile(rb"[0-9]+\.?[0-9]*$")
_MOST_PLACES = 400  #: Digits before an exponent that are looked at: as many as float64 has places.
_USUAL_BLANKS = 32  #: Exporters write a line end and a few blanks between statements.


@dataclass(frozen=True, slots=True, eq=False)
class Part21File:
    """The indexed text of one STEP file."""

    name: str  #: The file as the user named it, for messages.
    text: bytes  #: The text as read, without a byte order mark.
    clean: bytes  #: The same text with every comment replaced by blanks, so that all positions stay.
    ids: IntArray  #: shape (n,). Instance numbers, ascending.
    #: `starts`, `ends`: shape (n,). Positions of the ``#`` and the ``;`` of each instance, in the order of `ids`.
    starts: IntArray
    ends: IntArray
    header: tuple[StepRecord, ...]  #: The statements of the header.
    data_end: int  #: Position of the ``ENDSEC`` of the last data section. New instances go before it.
    byte_order_mark: bytes = b""  #: What an editor put before the text; `text` and all positions are without it.

    @property
    def newline(self) -> bytes:
        """The line end of the file."""
        return b"\r\n" if b"\r\n" in self.text[:4096] else b"\n"

    @property
    def schema(self) -> str:
        """First schema name of the header, without its object identifier; empty when not given."""
        names = self._header_argument("FILE_SCHEMA", 0)
        first = names[0] if isinstance(names, tuple) and names else ""
        return first.split("{")[0].strip() if isinstance(first, str) else ""

    @property
    def time_stamp(self) -> str:
        """Time stamp of the header as written; empty when not given."""
        stamp = self._header_argument("FILE_NAME", 1)
        return stamp if isinstance(stamp, str) else ""

    def _header_argument(self, keyword: str, index: int) -> Value:
        for record in self.header:
            if record.keyword == keyword and index < len(record.arguments):
                return record.arguments[index]
        return None

    def instance(self, number: int) -> Instance | None:
        """Parse one instance; None when the file has no instance of this number.

        Raises `FormatError` when its text is not a Part 21 instance.
        """
        at = int(np.searchsorted(self.ids, number))
        if at == len(self.ids) or int(self.ids[at]) != number:
            return None
        return self._parse(at)

    def instances(self, keyword: str) -> Iterator[Instance]:
        """Instances that hold a record with exactly this keyword, in the order of their numbers."""
        needle, seen = keyword.encode("ascii"), set[int]()
        order = np.argsort(self.starts, kind="stable")
        places = self.starts[order]
        at = self.clean.find(needle)
        while at >= 0:
            k = int(np.searchsorted(places, at, side="right")) - 1
            if k >= 0 and at < self.ends[order[k]]:
                seen.add(int(order[k]))
            at = self.clean.find(needle, at + len(needle))
        for index in sorted(seen):
            instance = self._parse(index)
            if instance.record(keyword) is not None:
                yield instance

    def _parse(self, at: int) -> Instance:
        start, end = int(self.starts[at]), int(self.ends[at])
        try:
            return parse_instance(self.clean[start:end])
        except FormatError as error:
            raise FormatError(str(error), path=self.name, line=line_of(self.text, start)) from None


def line_of(text: bytes, offset: int) -> int:
    """Line of a position in a text, counted from 1."""
    return text.count(b"\n", 0, offset) + 1


def index_part21(text: bytes, *, name: str) -> Part21File:
    """Find every statement of a STEP file.

    This takes a few milliseconds per megabyte: a few passes over the bytes with NumPy, and no Python loop over
    instances.

    Raises `FormatError` when a string or comment does not end, or the file is cut off: no data section, or one that
    does not end. When a number is too large for a float64: the kernel would take it as infinity, and may compute with
    it for ever.
    """
    clean = _blank_comments(text, name)
    _refuse_infinite(clean, text, name)
    characters = np.frombuffer(clean, dtype=np.uint8)
    ends = _statement_ends(characters, text, name)
    starts = _skip_space(clean, characters, np.concatenate([[0], ends[:-1] + 1]) if len(ends) else ends)
    is_instance = characters[starts] == _HASH if len(ends) else np.zeros(0, dtype=bool)
    header, data_end = _sections(clean, starts[~is_instance], ends[~is_instance], text, name)
    starts, ends = starts[is_instance], ends[is_instance]
    ids = _instance_numbers(characters, starts, text, name)
    if len(ids) and not np.all(ids[1:] > ids[:-1]):
        order = np.argsort(ids, kind="stable")
        ids, starts, ends = ids[order], starts[order], ends[order]
    return Part21File(name, text, clean, ids, starts, ends, header, data_end)


def reference_numbers(file: Part21File) -> tuple[IntArray, IntArray]:
    """Return where each ``#`` is in a file, and the number behind it; two arrays (k,).

    They are the references and the instances themselves, and any ``#`` in a string.

    Raises `FormatError` when a number has too many digits.
    """
    characters = np.frombuffer(file.clean, dtype=np.uint8)
    places = np.flatnonzero(characters == _HASH)
    places = places[places < len(characters) - MOST_DIGITS - 2]  # the last section ends with far more characters
    return places, _instance_numbers(characters, places, file.text, file.name)


def _blank_comments(text: bytes, name: str) -> bytes:
    """Replace every comment by as many blanks. Comment signs in strings and quotes in comments have no meaning."""
    pieces, done = [], 0
    while (at := text.find(b"/*", done)) >= 0:
        if text.count(b"'", done, at) % 2:  # `done` is outside strings, so an odd count puts `at` inside one
            end = text.find(b"'", at) + 1
            if not end:
                raise FormatError("a string does not end", path=name, line=line_of(text, at))
            pieces.append(text[done:end])
        else:
            end = text.find(b"*/", at + 2) + 2
            if end < 2:
                raise FormatError("a comment does not end", path=name, line=line_of(text, at))
            pieces += [text[done:at], b" " * (end - at)]
        done = end
    return b"".join([*pieces, text[done:]]) if done else text


def _refuse_infinite(clean: bytes, text: bytes, name: str) -> None:
    """Refuse a number outside strings that float64 cannot hold."""
    done, quotes = 0, 0
    for found in _LARGE_EXPONENT.finditer(clean):
        quotes += clean.count(b"'", done, found.start())
        done = found.start()
        digits = _LAST_DIGITS.search(clean, max(0, done - _MOST_PLACES), done)
        number = (digits[0] if digits else b"0") + found[0]
        if quotes % 2 == 0 and math.isinf(float(number)):
            what = (
                f"the number {shown(number.decode('ascii'))} is too large; the file is damaged there: export it again"
            )
            raise FormatError(what, path=name, line=line_of(text, done))


def _statement_ends(characters: NDArray[np.uint8], text: bytes, name: str) -> IntArray:
    """Positions of the semicolons outside strings: an even number of quotes precedes each of them."""
    quotes = np.flatnonzero(characters == _QUOTE)
    if len(quotes) % 2:
        raise FormatError("a string does not end", path=name, line=line_of(text, int(quotes[-1])))
    semicolons = np.flatnonzero(characters == _SEMICOLON)
    return np.asarray(semicolons[np.searchsorted(quotes, semicolons) % 2 == 0], dtype=np.int64)


def _skip_space(clean: bytes, characters: NDArray[np.uint8], places: IntArray) -> IntArray:
    """Move each position forward to the first character that is not blank. A semicolon follows each, so this ends.

    The first steps are array operations over all positions. The few positions before longer blanks (a comment was
    replaced) are then moved one by one, so that the time stays proportional to the size of the text.
    """
    places = places.copy()
    blank = np.flatnonzero(characters[places] <= ord(" "))
    for _ in range(_USUAL_BLANKS):
        places[blank] += 1
        blank = blank[characters[places[blank]] <= ord(" ")]
    for k in blank.tolist():
        found = _NOT_BLANK.search(clean, int(places[k]))
        places[k] = len(clean) if found is None else found.start()
    return places


def _instance_numbers(characters: NDArray[np.uint8], starts: IntArray, text: bytes, name: str) -> IntArray:
    """Read the digits behind each ``#``, one digit of all instances at a time, until the semicolons stop it."""
    numbers = np.zeros(len(starts), dtype=np.int64)
    digit = characters[starts + 1].astype(np.int64) - _ZERO
    live, place = np.arange(len(starts)), starts + 1
    while len(live):
        is_digit = (digit >= 0) & (digit <= 9)
        too_long = np.flatnonzero(is_digit & (place - starts[live] > MOST_DIGITS))
        if len(too_long):
            at = line_of(text, int(starts[live[too_long[0]]]))
            raise FormatError(f"an instance number has more than {MOST_DIGITS} digits", path=name, line=at)
        live, place, digit = live[is_digit], place[is_digit] + 1, digit[is_digit]
        numbers[live] = numbers[live] * 10 + digit
        digit = characters[place].astype(np.int64) - _ZERO
    return numbers


def _sections(
    clean: bytes, starts: IntArray, ends: IntArray, text: bytes, name: str
) -> tuple[tuple[StepRecord, ...], int]:
    """Walk the few statements that are not instances: header records, and the end of the last data section."""
    header: list[StepRecord] = []
    section, data_end = "", -1
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        statement = clean[start:end].rstrip()
        word = statement.split(b"(", 1)[0].strip().upper()
        if word == b"ENDSEC":
            data_end = start if section == "DATA" else data_end
            section = ""
        elif not section and word in (b"HEADER", b"DATA", b"ANCHOR", b"REFERENCE"):
            section = word.decode("ascii")
        elif section == "HEADER":
            header.append(_header_record(statement, text, start, name))
    if section == "DATA" or data_end < 0:
        what = "the data section does not end" if section == "DATA" else "there is no data section"
        raise FormatError(f"{what}; the file is cut off", path=name, line=line_of(text, len(text.rstrip())))
    return tuple(header), data_end


def _header_record(statement: bytes, text: bytes, start: int, name: str) -> StepRecord:
    try:
        value = parse_value(statement)
    except FormatError as error:
        raise FormatError(str(error), path=name, line=line_of(text, start)) from None
    if not isinstance(value, StepRecord):
        raise FormatError("expected a header record", path=name, line=line_of(text, start))
    return value
