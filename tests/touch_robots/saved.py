"""What a person copies from a controller after a run: its registers and variables, as its files hold them."""

import re
from typing import Any

SHOWN = 9  #: Characters of a number in `posreg.va`.


def fanuc(ran: Any, count: int = 100) -> dict[str, str]:
    """Return `numreg.va` and `posreg.va`; the controller drops the zero before the point of a small number."""
    rows = ["[*NUMREG*]$NUMREG  Storage: CMOS  Access: RW  : ARRAY[200] OF Numeric Reg"]
    for number in range(1, 201):
        value = ran.registers["R"].get(number, 0)
        rows.append(f"  [{number}] = {value if isinstance(value, int) else f'{value:.6f}'}  '' ")
    places = [f"[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[1,{count}] OF Position Reg"]
    for number in range(1, count + 1):
        place = ran.registers["PR"].get(number)
        if place is None:
            places.append(f"    [1,{number}] =   '' Uninitialized")
            continue
        x, y, z, w, p, r = map(_shown, place)
        places += [f"    [1,{number}] =   '' ", "  Group: 1   Config: N U T, 0, 0, 0"]
        places += [f"  X: {x}   Y: {y}   Z: {z}", f"  W: {w}   P: {p}   R: {r}"]
    return {"numreg.va": "\r\n".join(rows) + "\r\n", "posreg.va": "\r\n".join(places) + "\r\n"}


def _shown(value: float) -> str:
    text = re.sub(r"^(-?)0\.(?!0*$)", r"\1.", f"{value:.3f}")
    return f"{text:>{SHOWN}}" if len(text) <= SHOWN else "*" * (SHOWN - 1)


def inform(ran: Any) -> dict[str, str]:
    """Return `VAR.DAT`: a section for each kind of variable in the order of their numbers.

    That B, I and D are ten to a row, and P one, is public. What a row of P holds is not: here it is what a job has.
    """
    rows = ["//VAR", "///SHARE 100,100,100,100,100,128,128,128"]
    for kind in "BIDR":
        values = [ran.numbers.get(f"{kind}{n:03d}", 0) for n in range(100)]
        rows += [f"///{kind}", *(",".join(map(str, values[i : i + 10])) for i in range(0, 100, 10))]
    rows.append("///P")
    for number in range(128):
        place = ran.places.get(f"P{number:03d}")
        values = (0.0,) * 6 if place is None else place.values
        rows.append(",".join([*(f"{v:.3f}" for v in values[:3]), *(f"{v:.4f}" for v in values[3:])]))
    return {"VAR.DAT": "\r\n".join(rows) + "\r\n"}


def kawasaki(ran: Any) -> dict[str, str]:
    """Return what SAVE writes."""
    sections: dict[str, list[str]] = {".TRANS": [], ".REALS": [], ".STRINGS": []}
    for name, value in sorted(ran.values.items()):
        if isinstance(value, str):
            sections[".STRINGS"].append(f'{name.lower()} = "{value}"')
        elif isinstance(value, (int, float)):
            sections[".REALS"].append(f"{name.lower()} = {value:g}")
        elif not isinstance(value, tuple):
            sections[".TRANS"].append(f"{name.lower()} " + " ".join(f"{v + 0.0:.6f}" for v in value.values()))
    rows = [row for word, inside in sections.items() for row in (word, *inside, ".END")]
    return {"saved.as": "\r\n".join(rows) + "\r\n"}


def urscript(ran: Any) -> dict[str, str]:
    """Return the log."""
    return {"log.txt": "".join(f"2026-11-22 14:00:00.000 PolyScope: {row}\n" for row in ran.log)}
