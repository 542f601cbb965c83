"""A short fuzz in CI: every reader, some wrong inputs each, and every input that was a finding once."""

import random
from pathlib import Path

import pytest

from tests.few import few
from tests.fuzz.findings import FINDINGS
from tests.fuzz.judge import judge
from tests.fuzz.mutate import mutated
from tests.fuzz.targets import targets

INPUTS, FEW = 20, 8  #: For each reader, and for one that takes more than 3 ms; `make fuzz` draws others.
SLOW = ("export-", "picker", "rpc", "audit.", "cell-")
"""Their names begin so: they write programs, fit, or draw."""
KEPT = sorted(path.relative_to(FINDINGS).as_posix() for path in FINDINGS.glob("*/*") if path.parent.name in targets())
N = 300_000  #: Bytes of a large input. The readers before took more than 10 s for it, or for ten times as much.
LARGE = {
    "mod": {
        "declarations without an end": "CONST robtarget a:=" * (N // 19),
        "moves without an end": "MoveL a " * (N // 8),
        "many targets": "".join(f"CONST robtarget p{i}:=[[1,2,3],[1,0,0,0]];\n" for i in range(N // 45)),
        "brackets": "CONST robtarget a:=" + "[" * N + ";",
        "blanks": "CONST robtarget a" + " " * N + "x;",
        "arrays": "CONST robtarget a{" * (N // 18) + ";",
    },
    "ls": {
        "points without an end": "/POS\n" + "P[1]{\n" * (N // 6),
        "a coordinate without an end": "/POS\nP[1]{GP1:" + "X=" * (N // 2) + "}",
        "many points": "/POS\n" + "".join(f"P[{i}]{{\nGP1:\n}};\n" for i in range(N // 16)),
        "line ends": "/POS\nP[1]" + "\n" * N,
    },
    "dat": {
        "one line": "DECL E6POS XP1={" + "X 1," * (N // 4) + "}",
        "a word": "a" * N + "={",
        "blanks": "DECL" + " " * N,
    },
    "as": {
        "commas": ".TRANS\na " + "," * N,
        "one name": ".TRANS\n" + "a" * N,
        "sections": ".PROGRAM\n" * (N // 9),
        "moves": ".PROGRAM a()\nLMOVE " + "a," * (N // 2),
        "brackets": ".PROGRAM a()\nPOINT a = TRANS(" + "(" * N,
    },
    "audit-two-wpcal_w2.ls": {
        "positions without an end": "/PROG a\n/MN\n   1:L P[1] 1mm/sec FINE COORD ;\n/POS\n" + "P[1]{\n" * (N // 6),
    },
    "audit-two-WPCAL_W2_R1.mod": {
        "marks twice": "MODULE a\nSyncMoveOn s,t;\n" + "".join(f"\\ID:={i},\n" for i in range(N // 24)) * 2,
    },
    "jbi": {"commas": "//POS\n///POSTYPE ROBOT\nC00000=" + "," * N},
    "taught": {
        "columns": "name,x_mm,y_mm,z_mm," + ",".join(f"c{i}" for i in range(N // 8)) + "\n1",
        "separators": "," * N,
        "a quote": '"' * N,
        "a long cell": "name,x_mm,y_mm,z_mm\nA," + "1" * 100_000 + ",2,3\n",
        "a long unit": "a " * 50_000 + "[mm]\n1",
    },
    "poses": {
        "many reflectors": "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,reflector\n"
        + "".join(f"{i % 60},{i // 60 % 60},10,20,{i / 3600},40,1000,2,3,r{i}\n" for i in range(N // 40)),
    },
    "seams": {
        "lists in lists": '{"schema": "wpcal/seams/1", "x": ' + "[" * 100_000 + "]" * 100_000 + "}",
        "lists in a list": '{"schema": "wpcal/seams/1", "x": ' + "[" * 900 + "]" * 900 + "}",
        "a long integer": '{"schema": "wpcal/seams/1", "x": ' + "9" * 5000 + "}",
        "an integer beyond float64": '{"schema": "wpcal/seams/1", "x": ' + "9" * 400 + "}",
        "half a surrogate pair": '{"schema": "wpcal/seams/1", "x": "\\ud800"}',
        "a key of half a pair": '{"schema": "wpcal/seams/1", "\\ud800": 1}',
    },
    "audit.script": {
        "blank lines": "\n" * N + "movel(p[0.1, 0, 0, 0, 0, 0x1])",
        "moves without an end": "movel(p[" * (N // 8),
        "many moves": "movel(p[0.1, 0, 0, 0, 0, 0])\n" * (N // 30),
    },
    "step": {
        "blanks": "ISO-10303-21;HEADER;ENDSEC;DATA;" + " " * N + "#1=A();ENDSEC;",
        "a comment": "ISO-10303-21;HEADER;ENDSEC;DATA;/*" + "x" * N + "*/#1=A();ENDSEC;",
        "a long number": "ISO-10303-21;HEADER;ENDSEC;DATA;#" + "1" * N + "=A();ENDSEC;",
        "a long reference": "ISO-10303-21;HEADER;ENDSEC;DATA;#1=PRODUCT_DEFINITION(#" + "1" * 5000 + ");ENDSEC;",
        "lists in lists": "ISO-10303-21;HEADER;ENDSEC;DATA;#1=PRODUCT_DEFINITION" + "(" * N + ");ENDSEC;",
    },
}  # fmt: skip


@pytest.mark.parametrize("name", targets())
def test_wrong_input_is_refused_in_one_clear_way(name: str, tmp_path: Path) -> None:
    target, rng = targets()[name], random.Random(name)
    for data in target.seeds:
        assert judge(target, data, tmp_path).was_read
    inputs = [
        mutated(rng.choice(target.seeds), target.seeds, rng) for _ in range(FEW if name.startswith(SLOW) else INPUTS)
    ]
    judged = [judge(target, data, tmp_path) for data in inputs]
    assert {one.fault for one in judged} == {""}
    assert not all(one.was_read for one in judged)


@pytest.mark.parametrize("finding", KEPT)
def test_a_finding_stays_mended(finding: str, tmp_path: Path) -> None:
    name = finding.partition("/")[0]
    assert judge(targets()[name], (FINDINGS / finding).read_bytes(), tmp_path).fault == ""


@pytest.mark.parametrize(("name", "case"), few([(name, case) for name, cases in LARGE.items() for case in cases], 4))
def test_large_input_takes_time_in_proportion(name: str, case: str, tmp_path: Path) -> None:
    """`judge` ends a reader that takes longer than 10 s."""
    assert judge(targets()[name], LARGE[name][case].encode(), tmp_path).fault == ""
