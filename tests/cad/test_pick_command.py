"""What `wpcal pick` must refuse before it reads the part."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from cad.cli.pick import pick
from wpcal.core.errors import InputError

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


@pytest.mark.parametrize("target", ["tee.step", "folder", "link.csv"])
def test_force_never_takes_the_part_or_a_folder_for_the_table(tmp_path: Path, target: str) -> None:
    part = Path(shutil.copy(TEE, tmp_path / "tee.step"))
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.csv").symlink_to(part)
    before = part.read_bytes()
    result = CliRunner().invoke(pick, [str(part), "-o", str(tmp_path / target), "--force", "--no-browser"])
    assert isinstance(result.exception, InputError)
    assert "is the part itself" in str(result.exception) or "is a directory" in str(result.exception)
    assert part.read_bytes() == before
