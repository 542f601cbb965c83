"""Readers of programs take time in proportion to the text: twice the text takes at most three times as long."""

import time
from contextlib import suppress
from pathlib import Path

import pytest

from tests.few import few
from wpcal.controllers.audit.programs import Surroundings, executed
from wpcal.controllers.registry import find_controller
from wpcal.core.errors import InputError

CHARACTERS = 30_000
LEAST_S = 0.03  #: Less is not measured.
TRIES = 4  #: The processor may be busy.
HOSTILE = {
    "as": (".PROGRAM a()\n", "  LMOVE a", "LMOVE a |C2MOVE |C2MOVE a   | fi | fi \n|,|a[|a[1,|POINT a = TRANS(| till"),
    "comau": ("PROGRAM a\n", "  MOVE LINEAR TO", "a := POS(|MOVE LINEAR TO |MOVE CIRCULAR TO a VIA |$UFRAME := |(|,| "),
    "fanuc": (
        "/PROG A\n/MN\n/POS\n",
        "  1:L P[1]",
        'P[1]{\n|P[1|GP1 :|"|{ |,| |/POS\n|P[1:"a"]{ GP1: X = 1 mm, |C P[1]\n :  |Offset,',
    ),
    "inform": (
        "/JOB\n//NAME A\n//POS\n",
        "MOVL C00001",
        "C00000=|C00000 = 1,|///USER 1\n|,| |///POSTYPE USER\n|MOVL C00000 V=1.0\n|SMOVL C00000 +MOVJ ",
    ),
    "krl": ("DEFDAT A PUBLIC\n", "LIN ", 'DECL E6POS X={|{X 1,|;|,| |LIN X\n|TOOL_DATA[1]={|"|X[|&'),
    "rapid": (
        "MODULE a\n",
        "  MoveL a",
        'CONST robtarget a:=[[|[|PERS tooldata t:=[TRUE,[[|!|;|PROC a()\n|MoveL a,|"|,| |CONST robtarget a;',
    ),
    "urscript": (
        "def a():\n",
        "  movel(",
        "p[|p[1,|movel(|movec(p[1,2,3,4,5,6],| |,|pose_trans(|wpt_goal =|movej([1,2]\n|set_tcp(p[ |) ,",
    ),
    "val3": ("", "  movel(a[1]", 'movel(|movec(a[1],| |a[|<Data name="a">|&amp;|<!--'),
}
"""The head of a file, the begin of a line, and what is repeated, with a bar between."""
CASES = [(name, unit) for name, (_, _, units) in HOSTILE.items() for unit in units.split("|")]


def seconds(brand: str, text: str) -> float:
    """Processor time of everything that reads a text of this language."""
    controller = find_controller(brand)
    grammar, path = controller.load_grammar(), Path(f"a{controller.program_suffixes[0]}")
    start = time.process_time()
    with suppress(InputError):
        grammar.read(text, str(path))
    for line in text.splitlines():
        grammar.is_harmless(line)
    executed({path.name: text.encode()}, Surroundings())
    grammar.is_touch_program(text.encode(), path)
    with suppress(InputError):
        (grammar.tools or len)(text)
    if grammar.judge_step is not None:
        list(grammar.judge_step(text.splitlines(), path))
    return time.process_time() - start


@pytest.mark.parametrize(
    ("brand", "unit"), few(CASES, 4), ids=[f"{brand}-{unit.strip()[:12]}" for brand, unit in CASES]
)
def test_twice_the_text_takes_at_most_three_times_as_long(brand, unit):
    head, lead, _ = HOSTILE[brand]
    count = CHARACTERS // len(unit)
    for text in (head, head + lead):
        tries = (
            seconds(brand, text + 2 * count * unit) <= max(3.0 * seconds(brand, text + count * unit), LEAST_S)
            for _ in range(TRIES)
        )
        assert any(tries)
