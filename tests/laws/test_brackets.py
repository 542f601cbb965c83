"""What `seams` accepts on a bracket drawn at random, `export` writes: one judgement of reach."""

import json
from pathlib import Path

import pytest

from tests.few import few
from tests.judgements import calibrated
from tests.running import run_here
from tests.samples.brackets import write_bracket

DRAWN = 100
pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.mark.parametrize("seed", few([1, 4, *(seed for seed in range(DRAWN) if seed not in (1, 4))], 2))
def test_export_leaves_no_accepted_seam_out(seed: int, tmp_path: Path) -> None:
    out, _ = calibrated(write_bracket(seed, tmp_path), tmp_path)
    seams = json.loads((out / "seams.json").read_text(encoding="utf-8"))["seams"]
    accepted = sum(seam["accepted"] for seam in seams)
    assert accepted >= 4  # a web on the base has as many
    done = run_here("export", out, "-f", "rapid", "-o", tmp_path / "programs", "--json")
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)["seams"]) == accepted
