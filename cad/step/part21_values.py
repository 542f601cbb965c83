"""The values in a STEP file (ISO 10303-21): instances, records, strings and reals, parsed and written."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import NoReturn, TypeAlias

from wpcal.core.errors import FormatError

MOST_DIGITS = 18  #: Digits of an instance number or an integer: such a number fits into 64 bits. Real files need seven.
_TOKEN = re.compile(
    rb"""\s+
    |(?P<string>'(?:[^']|'')*')
    |(?P<ref>\#[0-9]+)
    |(?P<number>[+-]?[0-9]+(?:\.[0-9]*(?:[eE][+-]?[0-9]+)?)?)
    |(?P<enumeration>\.[A-Za-z_][A-Za-z0-9_]*\.)
    |(?P<keyword>!?[A-Za-z_][A-Za-z0-9_]*)
    |(?P<binary>"[0-9A-Fa-f]*")
    |(?P<mark>[()=,$*])""",
    re.VERBOSE,
)


class Ref(int):
    """A reference to an instance: ``#12``."""

    __slots__ = ()


class Enumeration(str):
    """An enumeration, stored without its dots (``.METRE.``), or ``*``, which marks a derived value."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One ``KEYWORD(arguments)``: a whole instance, a part of a complex instance, or a typed argument."""

    keyword: str
    arguments: tuple[Value, ...]


Value: TypeAlias = "int | float | str | bytes | Ref | Enumeration | StepRecord | tuple[Value, ...] | None"


@dataclass(frozen=True, slots=True)
class Instance:
    """One instance: its number and its record (several records for a complex instance)."""

    id: int
    records: tuple[StepRecord, ...]

    @property
    def keyword(self) -> str:
        """Keyword of a simple instance; the first keyword of a complex one."""
        return self.records[0].keyword

    def record(self, keyword: str) -> StepRecord | None:
        """Return the record with this keyword, or None."""
        return next((record for record in self.records if record.keyword == keyword), None)

    def references(self) -> tuple[int, ...]:
        """All references in the arguments, at any depth, in the order of the text."""
        found: list[int] = []
        stack: list[Value] = list(reversed(self.records))
        while stack:
            value = stack.pop()
            if isinstance(value, Ref):
                found.append(int(value))
            elif isinstance(value, StepRecord | tuple):
                stack.extend(reversed(value.arguments if isinstance(value, StepRecord) else value))
        return tuple(found)


def parse_instance(statement: bytes) -> Instance:
    """Read ``#12=KEYWORD(…)`` or the complex ``#12=(A(…)B(…))``, without comments and semicolon.

    Raises `FormatError` when the text is neither.

    >>> parse_instance(b"#7=DIRECTION('',(0.,0.,1.))")
    Instance(id=7, records=(StepRecord(keyword='DIRECTION', arguments=('', (0.0, 0.0, 1.0))),))
    """
    left, _, right = statement.partition(b"=")
    number = left.strip()
    if not (number[:1] == b"#" and number[1:].isdigit() and len(number) <= MOST_DIGITS + 1):
        _refuse(statement, "expected an instance #number=")
    value = parse_value(right)
    if isinstance(value, StepRecord):
        return Instance(int(number[1:]), (value,))
    if isinstance(value, tuple) and value and all(isinstance(part, StepRecord) for part in value):
        return Instance(int(number[1:]), tuple(part for part in value if isinstance(part, StepRecord)))
    return _refuse(statement, "expected a keyword with arguments")


def parse_value(text: bytes) -> Value:
    """Read one value: a number, string, reference, enumeration, record or list, nested to any depth.

    Raises `FormatError` when the text is not exactly one value.
    """
    root: list[Value] = []
    stack: list[tuple[str | None, list[Value]]] = [(None, root)]
    keyword: str | None = None
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            _refuse(text[position:], "expected a value")
        position, kind = match.end(), match.lastgroup
        if kind is None:
            continue
        token = match.group()
        if keyword is not None and token != b"(":
            _refuse(text, f"expected ( after {keyword}")
        if kind == "keyword":
            keyword = token.decode("ascii").upper()
        elif token == b"(":
            stack.append((keyword, []))
            keyword = None
        elif token == b")":
            if len(stack) == 1:
                _refuse(text, "a bracket closes that was not opened")
            name, values = stack.pop()
            stack[-1][1].append(tuple(values) if name is None else StepRecord(name, tuple(values)))
        elif token == b"=":
            _refuse(text, "an equals sign inside a value")
        elif token != b",":
            stack[-1][1].append(_plain(kind, token))
    if len(stack) > 1 or keyword is not None or len(root) != 1:
        _refuse(text, "expected one whole value")
    return root[0]


def format_instance(instance: Instance) -> bytes:
    """Write an instance as text that `parse_instance` reads back, without the semicolon.

    >>> format_instance(parse_instance(b"#7=(A($,.T.)B((1,2.),*,'it''s'))"))
    b"#7=(A($,.T.)B((1,2.),*,'it''s'))"
    """
    records = "".join(map(_format_value, instance.records))
    return f"#{instance.id}={records if len(instance.records) == 1 else f'({records})'}".encode("ascii")


def _format_value(value: Value) -> str:
    match value:
        case StepRecord() | tuple():
            inner = ",".join(map(_format_value, value.arguments if isinstance(value, StepRecord) else value))
            text = f"{value.keyword if isinstance(value, StepRecord) else ''}({inner})"
        case None:
            text = "$"
        case Ref():
            text = f"#{int(value)}"
        case Enumeration():
            text = "*" if value == "*" else f".{value}."
        case str():
            text = encode_string(value).decode("ascii")
        case bytes():
            text = f'"{value.decode("ascii")}"'
        case _:
            text = format_real(value) if isinstance(value, float) else str(value)
    return text


def _plain(kind: str, token: bytes) -> Value:
    if kind == "number":
        return _number(token)
    if kind == "ref":
        if len(token) > MOST_DIGITS + 1:
            _refuse(token, f"a reference has more than {MOST_DIGITS} digits")
        return Ref(token[1:])
    if kind == "string":
        return decode_string(token[1:-1])
    if kind == "enumeration":
        return Enumeration(token.strip(b".").decode("ascii").upper())
    if kind == "binary":
        return token[1:-1]
    return None if token == b"$" else Enumeration("*")


def _number(token: bytes) -> int | float:
    if b"." not in token:
        if len(token) > MOST_DIGITS + 1:
            _refuse(token, f"an integer has more than {MOST_DIGITS} digits")
        return int(token)
    value = float(token)
    if not math.isfinite(value):
        _refuse(token, "a real number is too large")
    return value


def _refuse(text: bytes, what: str) -> NoReturn:
    shown = text[:60].decode("utf-8", errors="replace")
    raise FormatError(f"{what}, found {shown!r}")


_ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-Fa-f]{4})*)\\X0\\|\\X4\\((?:[0-9A-Fa-f]{8})*)\\X0\\|\\X\\([0-9A-Fa-f]{2})|\\S\\(.)|\\P[A-I]\\|(\\\\)|('')",
    re.DOTALL,
)


def decode_string(raw: bytes) -> str:
    r"""Turn the inside of a Part 21 string into text.

    Escapes are ``''``, ``\\``, ``\X2\…\X0\``, ``\X4\…\X0\``, ``\X\hh``, ``\S\c`` and ``\PA\``.

    Bytes above 127 are forbidden by the standard, but some exporters write them. They are read as UTF-8, or as Latin-1
    where they are not UTF-8.
    """
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return _ESCAPE.sub(_unescape, text) if "\\" in text or "''" in text else text


def _unescape(match: re.Match[str]) -> str:
    utf16, utf32, latin, shifted, backslash, quote = match.groups()
    if utf16 is not None:
        return bytes.fromhex(utf16).decode("utf-16-be", errors="replace")
    if utf32 is not None:
        return bytes.fromhex(utf32).decode("utf-32-be", errors="replace")
    if latin is not None:
        return chr(int(latin, 16))
    if shifted is not None:  # the character 128 places further on in ISO 8859-1 (clause 6.4.3.2)
        return chr(ord(shifted) + 128) if ord(shifted) < 128 else shifted
    return "\\" if backslash else "'" if quote else ""


def encode_string(text: str) -> bytes:
    r"""Turn text into a Part 21 string with its quotes, in plain ASCII.

    >>> encode_string("Träger 'A'")
    b"'Tr\\X2\\00E4\\X0\\ger ''A'''"
    """
    pieces = []
    for run in re.findall(r"[ -~]+|[^ -~]+", text):
        if " " <= run[0] <= "~":
            pieces.append(run.replace("\\", "\\\\").replace("'", "''"))
        else:
            pieces.append(f"\\X2\\{run.encode('utf-16-be', errors='replace').hex().upper()}\\X0\\")
    return f"'{''.join(pieces)}'".encode("ascii")


def format_real(value: float) -> str:
    """Write a real as Part 21 demands: always with a decimal point, the exponent as ``E``. It reads back unchanged.

    >>> format_real(1.0), format_real(1e-05), format_real(-2.5e+20)
    ('1.', '1.E-05', '-2.5E+20')
    """
    mantissa, _, exponent = repr(float(value)).partition("e")
    if mantissa.endswith(".0"):
        mantissa = mantissa[:-1]
    elif "." not in mantissa:
        mantissa += "."
    return f"{mantissa}E{exponent}" if exponent else mantissa
