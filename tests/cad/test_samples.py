"""The sample parts as files: the same bytes in every run, and every member with its own name and colour."""

import subprocess
import sys
from pathlib import Path

import pytest

from cad.samples.parts import SAMPLES
from cad.step.append_colors import with_solid_colors
from cad.step.new_file import new_step_text
from wpcal.core.errors import FormatError

RUNS = 3
"""Processes whose files are compared. An order by address differs between most of them: six runs showed four orders of
the frame's rails."""

DIGESTS = """
import hashlib
from cad.samples.parts import SAMPLES
from cad.step.new_file import new_step_text
for name, sample in SAMPLES.items():
    print(name, hashlib.sha256(new_step_text(sample.build(), name)).hexdigest())
"""


@pytest.mark.deep
def test_samples_are_the_same_bytes_in_every_process() -> None:
    command = [sys.executable, "-c", DIGESTS]
    runs = {subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(RUNS)}
    assert len(runs) == 1
    assert next(iter(runs)).count("\n") == len(SAMPLES)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_sample_is_read_back_with_the_names_and_colours_of_its_members(name: str, tmp_path: Path) -> None:
    from cad.kernel.xcaf import srgb
    from cad.step.read import read_step

    members = SAMPLES[name].build()
    path = tmp_path / "part.step"
    path.write_bytes(new_step_text(members, name))
    part = read_step(path)
    assert part.issues == ()
    assert [(solid.name, solid.color_rgb) for solid in part.solids] == [
        (member, srgb(rgb)) for member, _, rgb in members
    ]


def test_colours_and_solids_are_as_many() -> None:
    text = new_step_text(SAMPLES["lap"].build(), "lap")
    with pytest.raises(FormatError, match="a solid for each of 1 colours, found 2"):
        with_solid_colors(text, [(1.0, 0.0, 0.0)], name="lap")
