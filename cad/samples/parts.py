"""Sample parts with known seams and a known pose, for `fixtures/` and `wpcal demo`.

`python -m cad.samples.parts FOLDER` writes all of them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box, cut, cylinder, prism
from cad.kernel.to_brep import to_brep
from cad.step.new_file import Member, new_step_text
from cad.workpiece.calibrate import WrittenCalibration, calibrate_files
from cad.workpiece.means import USUAL_MEANS, Means
from wpcal.core.arrays import FloatArray
from wpcal.core.progress import Progress, no_progress
from wpcal.core.records import to_json, write_file
from wpcal.core.transform import RigidTransform
from wpcal.taught.features import feature_named, find_features

TRUTH_SCHEMA = "wpcal/truth/1"
TEACHING_SIGMA_MM = 0.1
"""Standard deviation per axis of the sample's taught points: a careful touch with a straight wire."""
TEACHING_SEED = 2003

SAMPLE_INPUTS = ("tee.step", "taught.csv")  #: Names of the inputs of `wpcal demo` in its folder.
T_BASE_PART = RigidTransform.from_six_tuple([812.5, -240.25, 155.75, 0.02, -0.035, 0.6], target="base", source="part")
"""Pose of every sample in the robot's base: rotated and tilted, as a fitter would leave it."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One sample part."""

    name: str
    about: str  #: Description for people.
    build: Callable[[], list[Member]]  #: Returns the members.
    taught: tuple[str, ...]  #: Names of the features that are taught. Those after the fourth are check points.


STEEL, DARK = (0.45, 0.5, 0.55), (0.2, 0.3, 0.45)


def tee() -> list[Member]:
    """Return a plate 200 × 120 × 10 with an upright web 150 × 8 × 80: four fillets around the web."""
    base = cut(box(200, 120, 10, (0, 0, 0)), *(cylinder(5, 10, (x, 20, 0), (0, 0, 1)) for x in (20, 180)))
    return [("base plate", base, STEEL), ("web", box(150, 8, 80, (25, 56, 10)), DARK)]


def lap() -> list[Member]:
    """Return two plates 120 × 50 × 6 that overlap by 50 mm: four seams of 50 mm."""
    return [("lower", box(120, 50, 6, (0, 0, 0)), STEEL), ("upper", box(120, 50, 6, (70, 0, 6)), DARK)]


def saddle() -> list[Member]:
    """Return a pipe of 50 mm on a pipe of 100 mm, at a right angle and trimmed to its surface: a saddle seam."""
    run = cut(cylinder(50, 300, (-150, 0, 0), (1, 0, 0)), cylinder(45, 300, (-150, 0, 0), (1, 0, 0)))
    branch = cut(
        cylinder(25, 130, (0, 0, 0), (0, 0, 1)),
        cylinder(21, 130, (0, 0, 0), (0, 0, 1)),
        cylinder(50, 300, (-150, 0, 0), (1, 0, 0)),
    )
    return [("run pipe", run, STEEL), ("branch pipe", branch, DARK)]


FRAME_X_MM, FRAME_Y_MM, TUBE_MM, WALL_MM = 600.0, 400.0, 40.0, 3.0


def frame() -> list[Member]:
    """Return a frame 600 × 400 of four square tubes 40 × 3, mitred at the corners."""
    names = ("front rail", "right rail", "back rail", "left rail")
    return [(name, _mitred_tube(side), (STEEL, DARK)[side % 2]) for side, name in enumerate(names)]


def _mitred_tube(side: int) -> Any:
    """Return one rail: a trapezium drawn in the plane and extruded, with the bore cut out."""

    def extruded(inset: float, reach: float, bottom: float, top: float) -> Any:
        corners = [(x, y, bottom) for x, y in _rail_outline(side, inset, reach).tolist()]
        return prism(corners, (0, 0, top - bottom))

    return cut(extruded(0.0, TUBE_MM, 0.0, TUBE_MM), extruded(WALL_MM, TUBE_MM - WALL_MM, WALL_MM, TUBE_MM - WALL_MM))


def _rail_outline(side: int, inset: float, reach: float) -> FloatArray:
    """Return one side of the ring between two rectangles, cut at the mitres, shape (4, 2), mm."""
    size = np.array([FRAME_X_MM, FRAME_Y_MM])
    outer = np.array([[inset, inset], [size[0] - inset, inset], size - inset, [inset, size[1] - inset]])
    inner = np.array([[reach, reach], [size[0] - reach, reach], size - reach, [reach, size[1] - reach]])
    after = (side + 1) % 4
    return np.array([outer[side], outer[after], inner[after], inner[side]])


SAMPLES: dict[str, Sample] = {
    sample.name: sample
    for sample in (
        Sample("tee", "a web upright on a plate: fillets on both sides", tee, ("V2", "V4", "V16", "V12", "V6", "H1")),
        Sample("lap", "two plates that overlap by 50 mm", lap, ("V2", "V4", "V14", "V16", "V6", "V12")),
        Sample("saddle", "a pipe of 50 mm on a pipe of 100 mm", saddle, ("C2", "C6", "C4", "V1", "V4", "C3")),
        Sample("frame", "four mitred square tubes", frame, ("V3", "V7", "V59", "V63", "V27", "V39")),
    )
}


def write_sample(sample: Sample, folder: Path, *, overwrite: bool = False) -> None:
    """Write one sample: the STEP file, taught points without and with teaching error, and the truth.

    Raises `InputError` when a file exists and `overwrite` is false, or cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with kernel_call(f"making {sample.name}"):
        members = sample.build()
    write_file(folder / f"{sample.name}.step", new_step_text(members, sample.name), overwrite=overwrite)
    features = find_features(to_brep((name, shape) for name, shape, _ in members))
    p_part = np.array([feature_named(features, name).p_mm for name in sample.taught])
    exact = T_BASE_PART.apply(p_part)
    error = np.random.default_rng(TEACHING_SEED).normal(0.0, TEACHING_SIGMA_MM, exact.shape)
    write_file(folder / "taught_exact.csv", _taught_csv(sample.taught, exact, digits=9), overwrite=overwrite)
    write_file(folder / "taught.csv", _taught_csv(sample.taught, exact + error, digits=2), overwrite=overwrite)
    truth = {
        "schema": TRUTH_SCHEMA,
        "about": sample.about,
        "T_base_part": T_BASE_PART.matrix.tolist(),
        "teaching_sigma_mm": TEACHING_SIGMA_MM,
        "teaching_seed": TEACHING_SEED,
        "teaching_rounded_to_mm": 0.01,
    }
    write_file(folder / "truth.json", to_json(truth), overwrite=overwrite)


def _taught_csv(names: tuple[str, ...], p_base: FloatArray, *, digits: int) -> str:
    """Return a file of taught points. Those after the fourth are check points."""
    rows = [
        f"{name},{','.join(f'{v:.{digits}f}' for v in p)},{'yes' if row < 4 else 'check'}"
        for row, (name, p) in enumerate(zip(names, p_base, strict=True))
    ]
    return "\n".join(["name,x_mm,y_mm,z_mm,use", *rows, ""])


def calibrate_sample(
    *, out: Path, overwrite: bool, means: Means = USUAL_MEANS, progress: Progress = no_progress
) -> WrittenCalibration:
    """Write the T-joint and its taught points into a folder and calibrate it there, for ``wpcal demo``."""
    progress("making the sample part")
    write_sample(SAMPLES["tee"], out, overwrite=overwrite)
    part, taught = (out / name for name in SAMPLE_INPUTS)
    return calibrate_files(part, taught, out, overwrite=True, means=means, progress=progress)


def main(folder: str) -> None:
    """Write all samples below a folder, each in a folder of its own."""
    for sample in SAMPLES.values():
        write_sample(sample, Path(folder) / sample.name, overwrite=True)


if __name__ == "__main__":
    main(sys.argv[1])
