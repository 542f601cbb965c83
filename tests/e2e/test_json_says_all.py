"""``--json`` carries everything that the console shows: a law over all commands, which `test_hostile_folder` counts.

Every number of the console is in the printed record, or in a JSON file of the folder that the command wrote, to the
digits shown. Every note, warning, advice and verdict is there word for word.
"""

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.e2e.every_command import COMMANDS, FIXTURES, write_inputs
from tests.running import FINISHED, run_here
from tests.saddle import scan_coarsely

WIDE = "10000"  #: No line is broken.
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.\d{2,}(?:e[-+]?\d+)?(?![\w.])")
"""Numbers with two decimals or more: fewer would be found in any record by chance."""
MARKED = re.compile(r"^(?:note|warning|advice|PASS|UNSURE|FAIL|IMPROVED|NOT IMPROVED|taken): ?(.*)$")
LARGEST_RESIDUAL = re.compile(r"; the largest residual is .*$")
"""The console adds it to the sentence of the verdict; its number and point are looked for like all others."""
AGAIN = {"batch": "--resume"}
"""What lets a command write into its folder a second time, where that is not ``--force``."""
SLOW, SLOW_ODD = {"advise", "batch", "demo", "plan", "touches"}, {"advise", "plan"}
"""Commands that are deep tests: the law is the same for all of them, and tests of each of them read its record."""
NO_RECORD = {"pick": "it serves a page until Ctrl-C; the page has the records", "rpc": "every answer is a record"}

ODD = {
    "advise": "cm.step --count 3",
    "features": "cm.step",
    "seams": "cm.step",
    "sheet": "cm.step -o new.dxf --touch V2,V4,V16",
    "calibrate": "tee.step odd.csv -o new",
    "fit": "table1.csv --tolerance-mm 0.01",
    "identify": "mh6 --plan 20 -o new",
    "correct": "joints.csv --robot unseen.json --tool 0,0,100",
    "plan": "blocked.json seams.json --seam W1 -o new",
    "diff": "out other",
}
"""The same commands with input about which there is something to say."""
SAYS_NOTES = {"advise", "features", "seams", "sheet", "calibrate", "fit", "correct"}
"""Those whose odd input must lead to a note, or the law would hold by silence."""


@pytest.fixture(scope="module")
def folder(kernel_here: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The input of every command, and odd input; every command works in this process."""
    folder = tmp_path_factory.mktemp("commands")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("COLUMNS", WIDE)
        write_inputs(folder)
        _write_odd_input(folder)
        for out in ("out", "other"):
            sigma = () if out == "out" else ("--sigma-mm", "0.2")
            assert run_here("calibrate", "tee.step", "taught.csv", "-o", out, *sigma).returncode in FINISHED
        yield folder


def _write_odd_input(folder: Path) -> None:
    text = (folder / "tee.step").read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    (folder / "cm.step").write_text(text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)"))
    rows = (FIXTURES / "tee" / "taught_blunder.csv").read_text().splitlines()
    rows[-1] = rows[-1].replace("check", "no")
    (folder / "odd.csv").write_text("\n".join(rows) + "\n")
    arms = Path(__file__).parents[2] / "wpcal" / "robot" / "arms"
    arm = json.loads((arms / "mh6.json").read_text(encoding="utf-8"))
    (folder / "unseen.json").write_text(json.dumps({**arm, "unseen_tool_mm": 1.5}))
    cell = json.loads((FIXTURES / "cells" / "two-mh6.json").read_text(encoding="utf-8"))
    cell["holder_robot"]["T_world_base"]["t_mm"] = [9000.0, 0.0, 0.0]
    (folder / "blocked.json").write_text(json.dumps(cell))


def _values(record: Any) -> Iterator[Any]:
    """Yield every key and every value inside a record."""
    if isinstance(record, dict):
        for key, value in record.items():
            yield key
            yield from _values(value)
    elif isinstance(record, list):
        for value in record:
            yield from _values(value)
    else:
        yield record


def _missing(shown: str, record: Any) -> list[str]:
    """Return the numbers and sentences of the console that the record does not have."""
    values = list(_values(record))
    texts = [value for value in values if isinstance(value, str)]
    numbers = [abs(float(value)) for value in values if isinstance(value, int | float)]
    numbers += [abs(float(number)) for text in texts for number in NUMBER.findall(text)]
    scaled = [number * factor for number in numbers for factor in (1.0, 100.0, math.degrees(1.0))]  # percent, degrees
    missing = []
    for number in NUMBER.findall(shown):
        digits, _, exponent = number.partition("e")
        half = 0.51 * 10.0 ** (int(exponent or 0) - len(digits.split(".")[1]))
        if not any(abs(value - abs(float(number))) <= half for value in scaled):
            missing.append(number)
    whole = "\n".join(texts)
    for line in shown.splitlines():
        marked = MARKED.match(line.strip())
        if marked:
            said = LARGEST_RESIDUAL.sub("", marked[1]).removeprefix("left out by hand (use no): ")
            missing += [part for part in (said.split(", ") if "use no" in line else [said]) if part not in whole]
    return missing


def _case(name: str, line: str, slow: set[str]) -> Any:
    return pytest.param(name, line, marks=[pytest.mark.deep] if name in slow else [])


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("command", "line"),
    [
        *(_case(name, line, SLOW) for name, line in COMMANDS.items() if name not in NO_RECORD),
        *(_case(name, line, SLOW_ODD) for name, line in ODD.items()),
    ],
    ids=[*(name for name in COMMANDS if name not in NO_RECORD), *(f"{name}, odd" for name in ODD)],
)
def test_json_has_every_number_and_sentence_of_the_console(
    command: str, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if command == "plan":
        scan_coarsely(monkeypatch)
    arguments = [command, *line.split()]
    overwrites = {"-o", "--png"} & set(arguments) and "--force" not in arguments
    arguments += [AGAIN.get(command, "--force")] if overwrites else []
    shown, printed = run_here(*arguments), run_here(*arguments, "--json")
    assert shown.returncode == printed.returncode, (shown.stderr, printed.stderr)
    assert shown.returncode in FINISHED, shown.stderr
    record = [json.loads(printed.stdout)]
    if "-o" in arguments and Path(arguments[arguments.index("-o") + 1]).is_dir():
        record += [json.loads(path.read_text()) for path in Path(arguments[arguments.index("-o") + 1]).glob("*.json")]
    heard = [line.removeprefix("wpcal: ") for line in shown.stderr.splitlines()]
    assert _missing("\n".join([shown.stdout, *heard]), record) == []
    if ODD.get(command) == line and command in SAYS_NOTES:
        assert any(MARKED.match(said.strip()) for said in [*shown.stdout.splitlines(), *heard])


@pytest.mark.usefixtures("folder")
def test_export_repeats_the_verdict() -> None:
    verdict = json.loads(Path("out/calibration.json").read_text())["verdict"]
    exported = run_here("export", "out", "-f", "json", "-o", "exported", "--json")
    assert json.loads(exported.stdout)["verdict"] == verdict
