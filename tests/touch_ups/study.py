"""Play many corrected programs, and count what is promised and what is true: ``python -m tests.touch_ups.study``."""

import argparse
import json
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.touch_ups.shop import Part, Truth, load
from wpcal.controllers.run.machine import Place
from wpcal.controllers.touchup.poses import ProgramPose, ProgramText
from wpcal.controllers.touchup.study import TouchUp, TouchUpOptions
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration, read_finished

F = NDArray[np.float64]
FIXTURES = Path(__file__).parents[2] / "fixtures"
TOUCH_MM, HAND_MM = 0.15, 0.2


@dataclass
class Wanted:
    """What the welder does."""

    seams: int = 3
    points: int = 3  #: Per seam.
    preference: bool = False
    clamp: bool = False
    rebase: bool = False
    moved: int = 0
    touches: int = 8
    tack_mm: float | None = None
    field_mm: float = 0.3
    length: float = 500.0


@dataclass
class Seen:
    """What came out of many trials."""

    covered: list[bool] = field(default_factory=list)
    untouched: list[tuple[float, float]] = field(default_factory=list)
    told: list[bool] = field(default_factory=list)
    clamp: list[bool] = field(default_factory=list)
    false_clamp: int = 0
    preference: list[bool] = field(default_factory=list)
    false_preference: int = 0
    bodies: list[bool] = field(default_factory=list)
    trials: int = 0


def moved_by(seed: int, mm: float, rad: float, about: F) -> F:
    """A random motion about a point."""
    rng = np.random.default_rng(seed)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(rng.normal(0, rad, 3)).as_matrix()
    T[:3, 3] = about - T[:3, :3] @ about + rng.normal(0, mm, 3)
    return T


def calibrated(
    folder: Path, part: Part, truth: Truth, rng: np.random.Generator, touches: int
) -> tuple[FinishedCalibration, F]:
    """Fit the model to touches by least squares; return the result, and the motion from the model of the truth."""
    finished = read_finished(folder)
    x = part.touchable[rng.permutation(len(part.touchable))[:touches]]
    q = x + truth.point(x) + rng.normal(0, TOUCH_MM, x.shape)
    R, _ = Rotation.align_vectors(q - q.mean(0), x - x.mean(0))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R.as_matrix(), q.mean(0) - R.as_matrix() @ x.mean(0)
    D = RigidTransform(T[:3, :3], T[:3, 3], "base", "base")
    record = json.loads(json.dumps(finished.calibration))
    for point, at, model in zip(record["points"][: len(q)], q, x @ T[:3, :3].T + T[:3, 3], strict=True):
        point["p_base_mm"], point["residual_mm"], point["use"] = at.tolist(), (at - model).tolist(), "yes"
    del record["points"][len(q) :]
    record["teaching_error"] |= {"sigma_mm": TOUCH_MM, "used_sigma_mm": TOUCH_MM}
    record["budget"]["robot"] = {"amplitude_mm": 0.25, "length_mm": 600.0, "rest_mm": 0.0, "origin": "assumed"}
    seams = tuple(replace(seam, frames=seam.frames.moved(D)) for seam in finished.seams)
    old = finished.T_base_part
    pose = RigidTransform(D.R @ old.R, D.R @ old.t_mm + D.t_mm, "base", "part")
    return replace(finished, seams=seams, calibration=record, T_base_part=pose), T


def program(tips: list[list[F]]) -> ProgramText:
    """A program of poses, with a pose before and after each seam."""
    poses = []
    for number, seam in enumerate(tips, 1):
        for row, T in enumerate(seam):
            away = T.copy()
            away[:3, 3] += 50.0 * T[:3, 2]
            line = 100 * number + row
            if row == 0:
                poses.append(ProgramPose(Place("p.mod", line), f"to_{number}", away, 0))
            poses.append(ProgramPose(Place("p.mod", line), f"S{number}_{row}", T, number))
            if row == len(seam) - 1:
                poses.append(ProgramPose(Place("p.mod", line), f"from_{number}", away, 0))
    return ProgramText({}, tuple(poses), frozenset({"t"}))


def play(folder: Path, wanted: Wanted, seed: int, seen: Seen) -> TouchUp:
    """Play one part."""
    rng = np.random.default_rng(seed)
    part = load(folder)
    truth = Truth.draw(
        rng, part, field_mm=wanted.field_mm, length=wanted.length, moved=wanted.moved, plate_mm=wanted.tack_mm or 1.5
    )
    finished, T = calibrated(folder, part, truth, rng, wanted.touches)
    rows = [np.unique(np.linspace(0, len(f) - 1, 3).round().astype(int)) for f in part.frames]
    places = [f[r] for f, r in zip(part.frames, rows, strict=True)]
    old = [[T @ tip for tip in seam] for seam in places]
    real = []
    for number, (seam, r) in enumerate(zip(places, rows, strict=True)):
        d = truth.seam(part, number)[r]
        real.append(seam[:, :3, 3] + d)
    new = [[tip.copy() for tip in seam] for seam in old]
    chosen = spread_out(part, min(wanted.seams, len(old)), rng)
    c = 0.5 * unit(rng.normal(size=2)) if wanted.preference else np.zeros(2)
    corrected = []
    for number in chosen:
        for row in rng.permutation(len(old[number]))[: wanted.points]:
            y, z = old[number][row][:3, 1], old[number][row][:3, 2]
            d = real[number][row] - old[number][row][:3, 3]
            hand = rng.normal(0, HAND_MM, 2) + c
            new[number][row][:3, 3] += y * (d @ y + hand[0]) + z * (d @ z + hand[1])
            corrected.append((number, int(row)))
    clamp = corrected[int(rng.integers(len(corrected)))] if wanted.clamp else None
    if clamp is not None:
        away = unit(rng.normal(size=2)) * 3.0
        tip = new[clamp[0]][clamp[1]]
        tip[:3, 3] += tip[:3, 1] * away[0] + tip[:3, 2] * away[1]
    if wanted.rebase:
        base = moved_by(seed, 5.0, 0.01, part.middle)
        new = [[base @ tip for tip in seam] for seam in new]
    found = TouchUp(finished, program(old), program(new), TouchUpOptions(tack_mm=wanted.tack_mm))
    count(found, part, rows, old, real, chosen, clamp, c, wanted, truth, seen)
    return found


def unit(v: F) -> F:
    """A direction."""
    return v / np.linalg.norm(v)


def spread_out(part: Part, count: int, rng: np.random.Generator) -> list[int]:
    """Seams far from one another, as a welder who was told where."""
    middles = np.array([f[len(f) // 2, :3, 3] for f in part.frames])
    chosen = [int(rng.integers(len(middles)))]
    while len(chosen) < count:
        apart = np.linalg.norm(middles[:, None] - middles[chosen][None], axis=2).min(axis=1)
        chosen.append(int(np.argmax(apart)))
    return chosen


def count(
    found: TouchUp,
    part: Part,
    frames: list[NDArray[np.int64]],
    old: list[list[F]],
    real: list[F],
    chosen: list[int],
    clamp: tuple[int, int] | None,
    c: F,
    wanted: Wanted,
    truth: Truth,
    seen: Seen,
) -> None:
    """Compare what is said with what is true."""
    seen.trials += 1
    explanation = found.explanation
    if explanation is None:  # the hand moved no point by as much as counts
        return
    tips = np.array([tip[:3, 3] for seam in old for tip in seam])
    where = [(i, int(j)) for i, rows in enumerate(frames) for j in rows]
    mean, C = explanation.seams_at(found.part.places(np.array(where)))
    bound = explanation.errors_95_mm(C)
    of = np.array([i for i, seam in enumerate(old) for _ in seam])
    R = np.array([tip[:3, :3] for seam in old for tip in seam])
    off = np.concatenate(real) - tips
    across = lambda d: np.linalg.norm(np.einsum("kij,ki->kj", R, d)[:, 1:], axis=1)  # noqa: E731
    before, after = across(off), across(off - mean)
    seen.covered += (np.linalg.norm(off - mean, axis=1) <= bound).tolist()
    for i in range(len(old)):
        pair = float(before[of == i].max()), float(after[of == i].max())
        if i not in chosen:
            seen.untouched.append(pair)
            said = next(each for each in found.seams if each.name == part.names[i])
            if pair[1] > pair[0] + 0.1:
                seen.told.append(said.says not in ("better", "a little better") or pair[1] <= said.after_95_mm)
    rows = {p.row for p in found.exceptions}
    want = None
    if clamp is not None:
        want = sum(len(seam) + 2 for seam in old[: clamp[0]]) + 1 + clamp[1]
        seen.clamp.append(want in rows)
    seen.false_clamp += len(rows - {want})
    if wanted.preference:
        kinds = list(found.offsets.values())
        seen.preference.append(bool(kinds) and all(np.linalg.norm(k.mean_mm - c) <= 0.1 for k in kinds))
    else:
        seen.false_preference += len(found.offsets)
    seen.bodies.append(set(found.bodies) == set(truth.bodies))


def main(argv: list[str]) -> None:
    """Print one line per way of correcting."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--parts", nargs="*", default=["frame"])
    parser.add_argument("--cases", default="")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(argv)
    cases = {
        "plain 4 points": Wanted(seams=4, points=1),
        "plain 3 seams": Wanted(),
        "3 touches, 4 points": Wanted(seams=4, points=1, touches=3),
        "4 touches, 3 seams": Wanted(touches=4),
        "clamp": Wanted(seams=4, clamp=True),
        "preference": Wanted(seams=4, preference=True),
        "preference, 8 seams": Wanted(seams=8, preference=True),
        "rebase": Wanted(rebase=True),
        "a plate moved": Wanted(seams=6, moved=1),
        "all plates tacked": Wanted(seams=6, moved=20, tack_mm=0.5),
    }
    for name, wanted in cases.items():
        if asked.cases not in name:
            continue
        seen = Seen()
        for part in asked.parts:
            folder = FIXTURES / part / "golden"
            for trial in range(asked.seed, asked.seed + asked.trials):
                play(folder, wanted, trial, seen)
        b, a = np.array(seen.untouched or [(1, np.nan)]).T
        print(
            f"{name:22s} covered {np.mean(seen.covered):.3f}  untouched {b.mean():.2f} -> {a.mean():.2f} "
            f"({np.median(a / b):.2f})  told {np.mean(seen.told) if seen.told else 1:.2f} of {len(seen.told)}  "
            f"clamp {np.mean(seen.clamp) if seen.clamp else 1:.2f} (false {seen.false_clamp}/{seen.trials})  "
            f"preference {np.mean(seen.preference) if seen.preference else 1:.2f} (false {seen.false_preference})  "
            f"bodies right {np.mean(seen.bodies):.2f}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
