"""What every face of wpcal says about one part: the same facts collected from each place, for the law of one judgement.

A part goes from STEP through seams, advice, calibration, welds, programs, page, machine interface, touches, a plan with
one robot, audit and verification. Each place adds what it says about a fact; `disagreements` returns the facts about
which two places differ.
"""

import json
import math
import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.one_robot_cells import one_robot_record, write_cell
from tests.rpc_client import RpcClient
from tests.running import run_here
from wpcal.core.rotations import rotation_from_zyx

ROUND_OFF = 1e-9  #: Relative: places that say a number in full.
R_BASE_PART = rotation_from_zyx(0.6, -0.035, 0.02)
P_BASE_PART_MM = np.array([812.5, -240.25, 155.75])
TOUCHES = (6, 4)
NOISE_MM = 0.1
PROGRAMS = ("rapid", "krl", "fanuc", "inform", "as", "urscript", "val3", "pdl2")
CONFIGURATION = ("--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0")
OPTIONS = {"sigma_mm": NOISE_MM, "tolerance_mm": 1.0}


@dataclass(slots=True)
class Said:
    """What was said: for each fact about a subject, the places and their values."""

    facts: dict[tuple[str, str], dict[str, Any]] = field(default_factory=lambda: defaultdict(dict))

    def add(self, place: str, fact: str, value: Any, subject: str = "") -> None:
        """Note what a place says about a fact of a subject (a seam, or the whole part)."""
        self.facts[fact, subject][place] = value

    def disagreements(self) -> list[str]:
        """Return one line per fact about which two places differ."""
        return [
            f"{fact} {subject}".strip() + ": " + ", ".join(f"{place} says {value}" for place, value in places.items())
            for (fact, subject), places in self.facts.items()
            if not all(agree(value, other) for value in places.values() for other in places.values())
        ]


@dataclass(frozen=True, slots=True)
class Printed:
    """A number as a sentence prints it: it agrees with all that are rounded to it."""

    text: str

    def __str__(self) -> str:
        return self.text


def agree(one: Any, other: Any) -> bool:
    """Whether two values say the same; a printed number says its digits only."""
    if isinstance(other, Printed):
        one, other = other, one
    if isinstance(one, Printed):
        digits = len(one.text.partition(".")[2])
        if isinstance(other, Printed):
            return one.text == other.text
        return abs(float(one.text) - float(other)) <= 0.5 * 10**-digits * (1 + 1e-6)
    if isinstance(one, float) or isinstance(other, float):
        return one is not None and other is not None and math.isclose(one, other, rel_tol=ROUND_OFF, abs_tol=ROUND_OFF)
    return bool(one == other)


def everything_said(part: Path, folder: Path, *, is_whole: bool = False) -> Said:
    """Drive a part through every face of wpcal, and return what each said; a whole drive plans touches and motions."""
    said = Said()
    seams = _answer("seams", "seams", part, "--json")
    _seams(said, "seams", seams)
    if not any(seam["accepted"] for seam in seams["seams"]):
        return said
    out, answer = calibrated(part, folder)
    calibration = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    _calibration(said, "calibration.json", calibration)
    _calibration(said, "calibrate --json", answer)
    _seams(said, "seams.json", json.loads((out / "seams.json").read_text(encoding="utf-8")))
    _page(said, (out / "report.html").read_text(encoding="utf-8"))
    result = json.loads((out / "job.json").read_text(encoding="utf-8"))["result"]
    for fact, key in (("verdict", "verdict"), ("error of the worst seam", "worst_seam_error_mm"), ("worst seam",) * 2):
        said.add("job.json", fact, result[key.replace(" ", "_")])
    _welds(said, out)
    _export(said, out, folder)
    _rpc(said, part, folder)
    if is_whole:
        _touches(said, part, folder)
        _plan(said, out, folder)
    _folder(said, out)
    return said


def calibrated(part: Path, folder: Path, *options: Path | str) -> tuple[Path, Any]:
    """Calibrate a part at the advised points; return the result folder and what the command prints."""
    taught, out = folder / "taught.csv", folder / "out"
    taught.write_text(_taught_table(_advice(part)), encoding="utf-8")
    words = [word for name, value in OPTIONS.items() for word in (f"--{name.replace('_', '-')}", str(value))]
    return out, _answer("calibrate", "calibrate", part, taught, "-o", out, *words, *options, "--json")


def _advice(part: Path) -> dict[str, Any]:
    """Return which features to touch; a small part has fewer places than are asked for at first."""
    every = (run_here("advise", part, "--count", str(count), "--json") for count in TOUCHES)
    return dict(json.loads(next(done.stdout for done in every if done.returncode in (0, 1))))


def _answer(place: str, *arguments: Path | str) -> Any:
    done = run_here(*arguments)
    assert done.returncode in (0, 1), f"{place}: {done.stderr}"
    return json.loads(done.stdout)


def _taught_table(advice: dict[str, Any]) -> str:
    """Return the advised features as a robot would touch them: moved, with a teaching error, written to 0.01 mm."""
    rng = np.random.default_rng(len(advice["points"]))
    rows = ["name,x_mm,y_mm,z_mm,use"]
    for point in advice["points"]:
        p = R_BASE_PART @ point["p_mm"] + P_BASE_PART_MM + rng.normal(scale=NOISE_MM, size=3)
        rows.append(f"{point['name']},{p[0]:.2f},{p[1]:.2f},{p[2]:.2f},yes")
    return "\n".join(rows) + "\n"


def _seams(said: Said, place: str, record: dict[str, Any]) -> None:
    seams = record["seams"]
    said.add(place, "accepted seams", [seam["name"] for seam in seams if seam["accepted"]])
    said.add(place, "torch", record["torch"]["name"])
    said.add(place, "length of wire", float(record["torch"]["wire_mm"]))
    said.add(place, "number of accepted seams", sum(seam["accepted"] for seam in seams))
    for member in record["members"]:
        said.add(place, "taken for", (member["taken_as"], member["factor"], member["why"]), member["solid"])
    for seam in seams:
        _keys(said, place, seam)
        if seam["accepted"] and isinstance(seam["frames"], list) and "u95_mm" in seam["frames"][0]:
            said.add(place, "95 % error", max(frame["u95_mm"] for frame in seam["frames"]), seam["name"])


def _keys(said: Said, place: str, seam: dict[str, Any]) -> None:
    for key in {"accepted", "length_mm", "joint", "weld", "confidence", "reachable", "closed"} & set(seam):
        said.add(place, key, seam[key], seam["name"])


def _calibration(said: Said, place: str, record: dict[str, Any]) -> None:
    judgement, teaching = record["judgement"], record["teaching_error"]
    said.add(place, "verdict", record["verdict"])
    said.add(f"{place}, judgement", "verdict", judgement["kind"])
    said.add(place, "worst seam", judgement["seam"])
    said.add(place, "tolerance", record["tolerance_mm"])
    said.add(place, "error of all seams together", judgement["error_95_mm"])
    for row in record["budget"]["seams"]:
        said.add(f"{place}, budget", "95 % error", row["error_95_mm"], row["seam"])
        if row["seam"] == judgement["seam"]:
            said.add(f"{place}, budget", "error of the worst seam", row["error_95_mm"])
    said.add(place, "teaching error", teaching["used_sigma_mm"])
    for row in (record["criteria"] or {"rows": []})["rows"]:
        if row["criterion"] == record["criterion"]:
            said.add(f"{place}, table of criteria", "error of the worst seam", row["seam_error_95_mm"])
    _sentence(said, f"{place}, sentence", judgement["sentence"])


def _sentence(said: Said, place: str, sentence: str) -> None:
    """Take the numbers out of the sentence of a verdict."""
    for fact, pattern in (
        ("error of all seams together", r"(?:seams are|seam \S+ is) within (\S+) mm|seams together by (\S+) mm"),
        ("error of the worst seam", r"seam \S+ may be off by (\S+) mm, all"),
        ("teaching error", r"teaching error (\S+) mm per axis"),
        ("number of accepted seams", r"the ([0-9]+) accepted seams"),
        ("tolerance", r"tolerance (?:is|of) (\S+) mm"),
    ):
        if found := re.search(pattern, sentence):
            said.add(place, fact, Printed(found[1] or found[2]))


def _page(said: Said, page: str) -> None:
    record = json.loads(re.findall(r'id="data">(.*?)</script>', page)[0])
    _calibration(said, "page", record["calibration"])
    for seam in record["seams"]:
        _keys(said, "page", seam)


def _welds(said: Said, out: Path) -> None:
    record = _answer("welds", "welds", out, "--json")
    said.add("welds", "accepted seams", [weld["name"] for weld in record["welds"]])
    for weld in record["welds"]:
        said.add("welds", "joint", weld["joint"], weld["name"])
        said.add("welds", "length_mm", weld["place"]["length_mm"], weld["name"])


def _export(said: Said, out: Path, folder: Path) -> None:
    """Write a program: it has every accepted seam, and what it leaves out it names."""
    formats = [word for name in PROGRAMS for word in ("-f", name)]
    done = run_here("export", out, *formats, "-f", "csv", *CONFIGURATION, "-o", folder / "programs", "--json")
    assert done.returncode in (0, 1), done.stderr
    record = json.loads(done.stdout)
    said.add("export", "verdict", record["verdict"])
    for name in PROGRAMS:
        _program(said, f"{name} program", max(map(_header, (folder / "programs" / name).iterdir()), key=len))
    left_out = {each["seam"] for each in record["left_out"]}
    assert left_out.isdisjoint(record["seams"])
    assert done.returncode == 1 or not left_out
    order = [name for name in said.facts["accepted seams", ""]["seams.json"] if name in {*record["seams"], *left_out}]
    said.add("export", "accepted seams", order)
    for checked in record["checked"]:
        if found := re.search(r"an? (\S+) torch .* wire ([0-9.]+) mm", checked):
            said.add("export, what was checked", "torch", found[1])
            said.add("export, what was checked", "length of wire", Printed(found[2]))


def _header(path: Path) -> str:
    """Return the comments of a program that has the verdict, as one line."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"\s*;?\n\s*(?:\d+:)?\s*[!;'#/-]*\s*", " ", text) if "calibration " in text else ""


def _program(said: Said, place: str, text: str) -> None:
    """Take the numbers out of the header of a program."""
    said.add(place, "verdict", re.search(r"calibration (\w+), tolerance", text)[1])  # type: ignore[index]
    _sentence(said, place, text)
    line = r"(\S+) -> \S+: (\w+) (\w+), (\S+) mm,[^>]*? 95 % error up to (\S+) mm"
    for name, joint, weld, length_mm, error_mm in re.findall(line, text):
        for fact, value in (("joint", joint), ("weld", weld)):
            said.add(place, fact, value, name)
        said.add(place, "length_mm", Printed(length_mm), name)
        said.add(place, "95 % error", Printed(error_mm), name)


def _rpc(said: Said, part: Path, folder: Path) -> None:
    """Ask the machine interface, on which the workbench stands, for the same calibration."""
    client = RpcClient()
    given = {"taught": {"path": str(folder / "taught.csv")}, "options": OPTIONS}
    try:
        handle = client.ask("open", path=str(part.resolve()))["handle"]
        _seams(said, "rpc seams", client.ask("seams", handle=handle))
        _calibration(said, "rpc calibrate", client.ask("calibrate", handle=handle, **given)["record"])
    finally:
        client.close()


def _touches(said: Said, part: Path, folder: Path) -> None:
    record = _answer("touches", "touches", part, "-o", folder / "touches", "--json")
    said.add("touches", "accepted seams", [row["seam"] for row in record["predicted"]["by_seam"]])
    said.add("touches", "length of wire", float(record["stick_out_mm"]))


def _plan(said: Said, out: Path, folder: Path) -> None:
    """Plan with one robot: its pieces and what it says is not welded are the accepted seams, to the last mm."""
    cell = write_cell(folder, one_robot_record())
    record = _answer("plan", "plan", cell, out, "-f", "rapid", "-o", folder / "plan", "--json")
    said.add("plan", "accepted seams", record["planned"])
    lengths = defaultdict[str, float](float)
    for row in (*record["seams"], *record["unwelded"]):
        lengths[row["seam"]] += row["to_mm"] - row["from_mm"]
    for name, length_mm in lengths.items():
        said.add("plan", "length_mm", length_mm, name)
    said.add("plan", "a folder as planned is clean", True)
    audited = json.loads(run_here("audit", folder / "plan", "--json").stdout)
    said.add("audit", "a folder as planned is clean", audited["faults"] == 0)


def _folder(said: Said, out: Path) -> None:
    """Audit and verify the folder as it is, and after one point of a seam was moved."""
    for state in ("as written", "one point moved"):
        audited = json.loads(run_here("audit", out, "--json").stdout)
        verified = json.loads(run_here("verify", out, "--json").stdout)
        said.add("audit", f"a folder {state} is clean", audited["faults"] == 0)
        said.add("verify", f"a folder {state} is clean", verified["checked"][0]["state"] == "as claimed")
        record = json.loads((out / "seams.json").read_text(encoding="utf-8"))
        next(seam for seam in record["seams"] if seam["accepted"])["frames"][0]["p_mm"][0] += 1.0
        (out / "seams.json").write_text(json.dumps(record), encoding="utf-8")
