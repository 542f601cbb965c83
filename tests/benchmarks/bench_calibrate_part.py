"""What a user waits for at the prompt; `bench_assemblies` measures the main job on large parts (`--part`)."""

import tempfile
from functools import reduce
from pathlib import Path

import numpy as np
from rich.table import Table

from tests.benchmarks.timing import ProcessUse, run_python
from wpcal.core.transform import RigidTransform

ROOT = Path(__file__).parents[2]
TEE = ROOT / "fixtures" / "tee"
REPEATS = 3  #: The least of so many runs counts.
T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")


def main() -> Table:
    table = Table("what", "asked", "measured", title="The main job")
    with tempfile.TemporaryDirectory() as folder:
        for row in at_the_prompt(Path(folder)):
            table.add_row(*row)
    return table


def at_the_prompt(folder: Path) -> list[tuple[str, str, str]]:
    """Cold processes, as a user starts them."""
    tee = ("calibrate", TEE / "tee.step", TEE / "taught.csv", "--force", "-o", folder / "out")
    pairs = ("fit", ROOT / "fixtures" / "yin2003" / "table1.csv")
    rows = []
    for name, command, asked_s, asked_mb in (
        ("wpcal --help", ("--help",), "0.3 s", ""),
        ("wpcal --version", ("--version",), "0.3 s", ""),
        ("wpcal fit, Table 1", pairs, "1 s", ""),
        ("wpcal calibrate fixtures/tee", tee, "6 s, aim 3 s", "700 MB"),
    ):
        use = reduce(ProcessUse.least, (run_python("-m", "wpcal", *command) for _ in range(REPEATS)))
        limit = f"≤ {asked_s}" + (f", ≤ {asked_mb}" if asked_mb else "")
        rows.append((name, limit, f"{use.wall_s:.2f} s, largest process at most {use.peak_mb:.0f} MB"))
    return rows


def write_taught(features: tuple, path: Path) -> None:
    chosen = [features[i] for i in np.linspace(0, len(features) - 1, 5).astype(int)]
    points = T_BASE_PART.apply(np.array([feature.p_mm for feature in chosen]))
    rows = [f"{feature.name},{','.join(map(repr, p))}" for feature, p in zip(chosen, points.tolist(), strict=True)]
    path.write_text("\n".join(["name,x_mm,y_mm,z_mm", *rows, ""]), encoding="utf-8")
