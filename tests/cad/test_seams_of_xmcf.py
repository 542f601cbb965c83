"""`wpcal seams --xmcf`: the edges at the welds of another program are the seams, and nothing else is."""

import json
from pathlib import Path

import pytest

from tests.running import kernel_work_here, run_here

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
WELD = (
    "<xmcf><version>3.1.1</version><connection_group id='1'><connected_to/><connection_list><connection_1d label='X'>"
    "<loc_list><loc v='0'>25 {y} 10</loc><loc v='1'>175 {y} 10</loc></loc_list><seamweld><y_joint/></seamweld>"
    "</connection_1d></connection_list></connection_group></xmcf>"
)


def test_the_edge_at_a_weld_of_the_file_is_the_only_seam(tmp_path, monkeypatch):
    monkeypatch.setattr("cad.work.child.run_in_child", kernel_work_here)
    file = tmp_path / "welds.xml"
    file.write_text(WELD.format(y=56.5))
    ended = run_here("seams", TEE, "--xmcf", file, "--json", "--no-cache")
    (seam,) = [seam for seam in json.loads(ended.stdout)["seams"] if seam["accepted"]]
    assert seam["candidate"]["middle_part_mm"] == pytest.approx([100.0, 56.0, 10.0])
    assert seam["source"] == "marked or picked edge"
