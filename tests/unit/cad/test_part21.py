import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cad.step.part21 import index_part21
from cad.step.part21_values import (
    Enumeration,
    Ref,
    StepRecord,
    decode_string,
    encode_string,
    format_real,
    parse_instance,
    parse_value,
)
from wpcal.core.errors import FormatError

HEAD = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('a','2001-02-03T04:05:06',(''),(''),'','','');\n"
)
HEAD += "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
TAIL = "ENDSEC;\nEND-ISO-10303-21;\n"


def part21(body: str) -> bytes:
    return (HEAD + body + TAIL).encode("utf-8")


# Values ---------------------------------------------------------------------------------------------------------------

plain_texts = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=30)
texts = plain_texts | st.lists(st.sampled_from(["/*", "*/", "'", ";", "#1=A();", "\\", "ä"]), max_size=6).map("".join)
names = st.from_regex(r"[A-Z][A-Z0-9_]{0,15}", fullmatch=True)
leaves = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.integers(-(10**9), 10**9),
    texts,
    st.integers(1, 10**9).map(Ref),
    names.map(Enumeration),
    st.just(Enumeration("*")),
    st.none(),
)
values = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4).map(tuple), st.builds(StepRecord, names, st.lists(inner, max_size=4).map(tuple))
    ),
    max_leaves=12,
)
gaps = st.sampled_from(["", " ", "\n", "\r\n", "  \t"])
comments = st.sampled_from(["", "/**/", "/* ; ' ( */", "/* don't; #9=X(); */", "/* a\n;* b **/"])


def written(value: object, gap: str) -> str:
    """Write a value as Part 21 text, with blanks wherever they are allowed."""
    if isinstance(value, StepRecord):
        return f"{value.keyword}{gap}{written(value.arguments, gap)}"
    if isinstance(value, tuple):
        return f"({gap}{f'{gap},{gap}'.join(written(item, gap) for item in value)}{gap})"
    return written_leaf(value)


def written_leaf(value: object) -> str:
    if isinstance(value, Ref):
        return f"#{int(value)}"
    if isinstance(value, Enumeration):
        return "*" if value == "*" else f".{value}."
    if isinstance(value, str):
        return encode_string(value).decode("ascii")
    if value is None:
        return "$"
    return format_real(value) if isinstance(value, float) else str(value)


def same(a: object, b: object) -> bool:
    """Equal, and of one type: 1 is not 1.0, and a reference is not its number."""
    if isinstance(a, StepRecord) and isinstance(b, StepRecord):
        return a.keyword == b.keyword and same(a.arguments, b.arguments)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and a == b


@given(values, gaps)
def test_a_written_value_reads_back(value: object, gap: str) -> None:
    assert same(parse_value(written(value, gap).encode("ascii")), value)


@given(texts)
def test_a_string_reads_back_and_is_plain_ascii(text: str) -> None:
    raw = encode_string(text)
    assert raw.isascii()
    assert decode_string(raw[1:-1]) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_real_has_the_standards_form_and_reads_back(value: float) -> None:
    text = format_real(value)
    mantissa, _, exponent = text.partition("E")
    assert "." in mantissa
    assert not exponent or exponent.lstrip("+-").isdigit()
    assert float(text) == value
    assert math.copysign(1.0, float(text)) == math.copysign(1.0, value)


@pytest.mark.parametrize(
    ("raw", "text"),
    [
        (b"it''s", "it's"),
        (rb"Tr\X2\00E4\X0\ger", "Träger"),
        (rb"\X2\D83DDE00\X0\!", "😀!"),
        (rb"\X4\0001F600\X0\!", "😀!"),
        (rb"\X\E9t\X\E9", "été"),
        (rb"\S\d", "ä"),
        (rb"a\\b", r"a\b"),
        (rb"\PA\x", "x"),
        ("Träger".encode(), "Träger"),
        ("Träger".encode("latin-1"), "Träger"),
    ],
)
def test_every_escape_of_the_standard_is_read(raw: bytes, text: str) -> None:
    assert decode_string(raw) == text


def test_a_complex_instance_has_its_records_in_order() -> None:
    instance = parse_instance(b"#12 = ( LENGTH_UNIT() NAMED_UNIT(*)\r\nSI_UNIT(.MILLI.,.METRE.) )")
    assert instance.id == 12
    assert [record.keyword for record in instance.records] == ["LENGTH_UNIT", "NAMED_UNIT", "SI_UNIT"]
    assert instance.record("SI_UNIT") == StepRecord("SI_UNIT", (Enumeration("MILLI"), Enumeration("METRE")))
    assert instance.record("AREA_UNIT") is None


def test_references_are_found_at_any_depth_in_order() -> None:
    assert parse_instance(b"#1=A(#5,(#7,B(#6)),'#9',#5)").references() == (5, 7, 6, 5)


def test_ten_thousand_nested_brackets_are_no_recursion() -> None:
    value = parse_value(b"(" * 10_000 + b")" * 10_000)
    assert isinstance(value, tuple)


@pytest.mark.parametrize(
    "text", [b"", b"(", b")", b"A", b"A B()", b"'open", b"1 2", b"(1))", b"A(=)", b"@", b".OPEN", b"((1)"]
)
def test_what_is_no_value_is_refused(text: bytes) -> None:
    with pytest.raises(FormatError):
        parse_value(text)


@pytest.mark.parametrize("text", [b"A()", b"#=A()", b"#x=A()", b"#1=", b"#1='text'", b"#1=(1,2)", b"#1=()"])
def test_what_is_no_instance_is_refused(text: bytes) -> None:
    with pytest.raises(FormatError):
        parse_instance(text)


# The index ------------------------------------------------------------------------------------------------------------


@pytest.mark.deep
@given(
    st.lists(st.tuples(names, st.lists(values, max_size=3).map(tuple)), min_size=1, max_size=8),
    st.randoms(use_true_random=False),
    st.sampled_from(["\n", "\r\n", ""]),
    comments,
    gaps,
)
def test_every_instance_is_found_whatever_stands_in_strings_and_comments(
    records, random, newline, comment, gap
) -> None:
    ids = random.sample(range(1, 1000), len(records))
    expected = {number: StepRecord(*record) for number, record in zip(ids, records, strict=True)}
    lines = [f"#{n}{gap}={gap}{comment}{written(record, gap)}{gap};{comment}" for n, record in expected.items()]
    file = index_part21(part21(newline.join(lines) + newline), name="part.step")
    assert file.ids.tolist() == sorted(ids)
    for number, record in expected.items():
        instance = file.instance(number)
        assert same(instance.records[0], record)
    assert file.instance(1000) is None
    assert len(file.clean) == len(file.text)


def test_instances_are_found_by_their_keyword_and_not_by_look_alikes() -> None:
    body = "#3=AB(#1);#1=A('B(');#2=B('A(');#5=(X()A(2)Y());/* #7=A(); */#6=C('#8=A();',A(1));"
    file = index_part21(part21(body), name="part.step")
    assert [instance.id for instance in file.instances("A")] == [1, 5]


def test_the_header_is_read() -> None:
    file = index_part21(part21("#1=A();\n"), name="part.step")
    assert file.schema == "AUTOMOTIVE_DESIGN"
    assert file.time_stamp == "2001-02-03T04:05:06"
    assert file.text[file.data_end :].startswith(b"ENDSEC;\nEND-ISO")


def test_new_entities_go_to_the_end_of_the_last_data_section() -> None:
    two = part21("#1=A();\nENDSEC;\nDATA('second',('X'));\n#2=B();\n")
    file = index_part21(two, name="part.step")
    assert file.text[: file.data_end].endswith(b"#2=B();\n")


@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
def test_the_line_end_is_that_of_the_file(newline: bytes) -> None:
    text = part21("#1=A();\n").replace(b"\n", newline)
    assert index_part21(text, name="part.step").newline == newline


def test_a_file_cut_anywhere_in_its_data_is_refused() -> None:
    text = part21("#1=A('x;');\n/* note */\n#2=B((1.,2.),#1);\n")
    for length in range(text.index(b"DATA;"), text.rindex(b"ENDSEC;") + len(b"ENDSEC")):
        with pytest.raises(FormatError, match=r"part\.step, line \d+"):
            index_part21(text[:length], name="part.step")


def test_a_broken_instance_is_refused_with_its_line() -> None:
    file = index_part21(part21("#1=A();\n#2=B(;\n"), name="part.step")
    with pytest.raises(FormatError, match=r"part\.step, line 9"):
        file.instance(2)
