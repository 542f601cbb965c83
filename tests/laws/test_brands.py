"""A maker's name, its language and its files are known in its own folder of `wpcal.controllers`, and nowhere else."""

import re
from pathlib import Path

from wpcal.controllers import controllers

ROOT = Path(__file__).parents[2]
MAKERS = "ABB KUKA FANUC Fanuc Yaskawa Motoman Kawasaki Staubli Comau"
LANGUAGES = "RAPID KRL INFORM URScript VAL3 PDL2 ArcWare ArcTech ArcTool SmarTac TouchSense"
ORDINARY = {"as", "inform", "ur"}  #: Names of formats and brands that are words of other things.
EXCEPTIONS = {
    "wpcal/core/pendant.py": "notations of poses, which calibration.json lists by maker; below the room of controllers",
    "wpcal/touch/searches/setup.py": "the sections of touch-setup.toml, a file format; below the room of controllers",
}


def words() -> re.Pattern[str]:
    names = {name for each in controllers() for name in (each.name, *each.brands)} - ORDINARY
    suffixes = {suffix for each in controllers() for suffix in (*each.suffixes, *each.program_suffixes)} - {".script"}
    quoted = "|".join(map(re.escape, sorted({*names, *suffixes, *ORDINARY - {"as"}})))
    return re.compile(rf"\b(?:{'|'.join(f'{MAKERS} {LANGUAGES}'.split())})\b|[\"'`](?:{quoted})[\"'`]")


def test_a_brand_is_known_in_its_own_folder_only():
    brands = {Path(each.writer.split(":")[0].replace(".", "/")).parts[2] for each in controllers()}
    pattern, found = words(), []
    for path in sorted([*(ROOT / "wpcal").rglob("*.py"), *(ROOT / "cad").rglob("*.py")]):
        name = path.relative_to(ROOT).as_posix()
        if (
            name in EXCEPTIONS
            or name.startswith(("cad/freecad/", "wpcal/robot/links/"))  # links have a file for each maker
            or (path.parts[-3], path.parts[-2]) in {("controllers", brand) for brand in brands}
        ):
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        found += [f"{name}:{number}: {line.strip()}" for number, line in enumerate(lines, 1) if pattern.search(line)]
    assert found == []


def test_the_exceptions_are_needed():
    for name in EXCEPTIONS:
        assert words().search((ROOT / name).read_text(encoding="utf-8")), name
