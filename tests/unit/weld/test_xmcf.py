"""xMCF: what is written is read again, other files are read or refused in one line, and seams take what files state.

The schema and the sample files of the working group carry no licence, so they are not here. `WPCAL_XMCF` names a folder
with them (V3.1.1 of economidis-nick/createXSDforxMCF); without it those tests are skipped.
"""

import math
import os
from contextlib import nullcontext, suppress
from pathlib import Path

import numpy as np
import pytest

from tests.running import run_here
from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import read_finished
from wpcal.weld.xmcf.match import match_xmcf
from wpcal.weld.xmcf.read import parse_xmcf, places_of, read_xmcf

SAMPLES = Path(os.environ.get("WPCAL_XMCF", "no-such-folder"))
SAME_MM = 1e-6  #: Files hold nine digits.
IDENTITY = RigidTransform(np.eye(3), np.zeros(3), "part", "base")


def xmcf(inner='<y_joint><weld_position u="0.5" x="0" y="0" z="1"/></y_joint>', units="", points="0 0 0;100 0 0"):
    locs = "".join(f'<loc v="{v}">{p}</loc>' for v, p in enumerate(points.split(";")))
    return (
        f"<xmcf><version>3.1.1</version>{units}<connection_group id='1'><connected_to><part index='1' label='a'/>"
        "<part index='2' label='b'/></connected_to><connection_list><connection_1d label='X'>"
        f"<loc_list>{locs}</loc_list><seamweld>{inner}</seamweld></connection_1d></connection_list></connection_group></xmcf>"
    ).encode()


SIDE = '<weld_position u="0" x="0" y="0" z="1" section="Fillet" thickness="4" angle="45">{}</weld_position>'


def test_units_and_values_are_those_of_the_file():
    side = SIDE.format('<regular_segments num_segments="3" length="0.02" spacing="0.03" first_spacing="0.01"/>')
    sheets = '<sheet_parameter index="1" gap="0.001" sheet_thickness="0.008"/>'
    inner = f'<y_joint technology="arc">{side.replace("4", "0.004", 1)}{sheets}</y_joint>'
    (seam,) = parse_xmcf(xmcf(inner, '<units length="m" angle="rad"/>', "0 0 0;0.1 0 0"), path="x.xml")
    assert (seam.label, seam.kind, seam.technology, seam.parts) == ("X", "y_joint", "arc", ("a", "b"))
    assert seam.lines_mm[0][1] == pytest.approx([100.0, 0.0, 0.0])
    assert (seam.thicknesses_mm, seam.gaps_mm) == ((8.0,), (1.0,))
    (one,) = seam.sides
    assert (one.throat_mm, one.angle_deg) == (4.0, pytest.approx(math.degrees(45.0)))
    assert (one.stitch.length_mm, one.stitch.pitch_mm, one.stitch.offset_mm) == (20.0, 50.0, 10.0)


@pytest.mark.parametrize(
    ("segments", "stitch"),
    [
        ([(10, 20), (40, 50), (70, 80)], (10.0, 30.0, 10.0)),
        ([(10, 20)], (10.0, 30.0, 10.0)),
        ([(10, 20), (40, 55)], None),
        ([(10, 20), (40, 50), (80, 90)], None),
    ],
)
def test_a_list_of_even_segments_is_a_stitch_and_another_is_told(segments, stitch):
    listed = "".join(f'<segment from="{a}" to="{b}"/>' for a, b in segments)
    (seam,) = parse_xmcf(xmcf(f"<y_joint>{SIDE.format(f'<segment_list>{listed}</segment_list>')}</y_joint>"), path="x")
    (side,) = seam.sides
    found = side.stitch and (side.stitch.length_mm, side.stitch.pitch_mm, side.stitch.offset_mm)
    assert (found, side.is_uneven) == (stitch, stitch is None)


NO_LENGTH = "<y_joint>" + SIDE.format('<regular_segments length="0" spacing="1"/>') + "</y_joint>"


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        (b"", "is not XML"),
        (b"<xmcf", "x.xml, line 1, column 0: is not XML"),
        (b"<robot/>", "expected an xMCF file"),
        (b'<?xml version="1.0" encoding="no-such"?><xmcf/>', "is not XML"),
        (xmcf(units='<units length="furlong"/>'), "units: expected mm, m, in or ft"),
        (xmcf(points="0 0 0"), "seam X: loc_list: expected at least two points, got 1"),
        (xmcf(points="0 0;1 0 0"), "seam X: loc: expected three numbers"),
        (xmcf(points="0 0 nan;1 0 0"), "seam X: loc: "),
        (xmcf(points="0 0 1e30;1 0 0"), "seam X: loc: expected a number of at most"),
        (xmcf("<z_joint/>"), "seam X: expected one of butt_joint"),
        (xmcf('<y_joint><sheet_parameter index="1" gap="wide"/></y_joint>'), "seam X: sheet_parameter gap: "),
        (xmcf(NO_LENGTH), "regular_segments"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_line(raw, message):
    with pytest.raises(FormatError, match=r"x\.xml") as raised:
        parse_xmcf(raw, path="x.xml")
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_coordinate_is_at_most_the_largest_in_mm():
    (seam,) = parse_xmcf(xmcf(points=f"0 0 0;1 0 {LARGEST_MM}"), path="x")
    assert seam.lines_mm[0][1, 2] == LARGEST_MM
    with pytest.raises(FormatError, match="expected coordinates of at most"):
        parse_xmcf(xmcf(units='<units length="m"/>', points=f"0 0 0;1 0 {LARGEST_MM}"), path="x")


def test_seams_take_what_the_file_states_at_their_side(make_seam):
    x = np.linspace(0.0, 100.0, 11)
    seam = make_seam("W1", np.stack([x, 0 * x, 0 * x], axis=1), np.broadcast_to(np.eye(3), (11, 3, 3)))
    other = SIDE.format("").replace('z="1"', 'z="-1"').replace('"4"', '"9"')
    sheet = '<sheet_parameter index="1" sheet_thickness="8"/>'
    inner = f'<y_joint technology="laser">{other}{SIDE.format("")}{sheet}</y_joint>'
    found = match_xmcf([seam], parse_xmcf(xmcf(inner), path="x"), IDENTITY, file="x.xml")
    assert found.stated[0].files == {
        "thickness_mm": (8.0, "x.xml"),
        "throat_mm": (4.0, "x.xml"),
        "weld": ("fillet weld", "x.xml"),
    }
    assert found.notes == ("W1: x.xml: X: is a laser weld there",)
    far = match_xmcf([seam], parse_xmcf(xmcf(points="0 9 0;100 9 0"), path="x"), IDENTITY, file="x.xml")
    assert (far.stated, far.dropped) == ((), ("X",))
    assert far.notes == ("x.xml: no seam that is welded is at X: dropped",)


def test_a_weld_on_a_part_of_a_seam_is_said_with_both_lengths(make_seam):
    x = np.linspace(0.0, 100.0, 11)
    seam = make_seam("W1", np.stack([x, 0 * x, 0 * x], axis=1), np.broadcast_to(np.eye(3), (11, 3, 3)))
    found = match_xmcf([seam], parse_xmcf(xmcf(points="20 0 0;80 0 0"), path="x"), IDENTITY, file="x.xml")
    assert [weld.name for weld in found.stated] == ["W1"]
    assert found.dropped == ()
    assert found.notes[0].startswith("W1: x.xml: X (60 mm) of 100 mm; the whole seam is welded")


SECTIONS = dict.fromkeys(("V", "Y"), "single-V") | dict.fromkeys(("HV", "HY"), "single-bevel")


@pytest.mark.parametrize(
    ("section", "kind"), [*SECTIONS.items(), ("X", "double-V"), ("K", "double-bevel"), ("I", "square")]
)
def test_the_groove_of_a_butt_is_that_of_the_file(make_seam, section, kind):
    x = np.linspace(0.0, 100.0, 11)
    seam = make_seam("W1", np.stack([x, 0 * x, 0 * x], axis=1), np.broadcast_to(np.eye(3), (11, 3, 3)))
    side = f'<weld_position u="0" x="0" y="0" z="1" section="{section}" angle="50"/>'
    found = match_xmcf([seam], parse_xmcf(xmcf(f"<butt_joint>{side}</butt_joint>"), path="x"), IDENTITY, file="x.xml")
    angle = {} if section == "I" else {"groove_angle_deg": (50.0, "x.xml")}
    assert found.stated[0].files == {"weld": (f"{kind} butt weld", "x.xml"), **angle}


def test_what_is_written_is_read_again(finished_folder, tmp_path):
    folder, file, welds = (
        finished_folder(names=("W1", "W2", "Ü<&>\x07"), accepted=(True,) * 3),
        tmp_path / "w.xml",
        tmp_path,
    )
    options = ("--set", "W1:throat_mm=4", "--set", 'W1:stitch={"length_mm":20,"pitch_mm":50}')
    assert run_here("welds", folder, *options, "--write-xmcf", file).returncode == 0
    seams = read_finished(folder).seams
    read = read_xmcf(file)
    assert [seam.label for seam in read] == ["W1", "W2", "Ü<&>_"]
    T_part_base = read_finished(folder).T_base_part.inverse()
    for written, seam in zip(read, seams, strict=True):
        assert np.abs(written.lines_mm[0] - T_part_base.apply(seam.frames.p)).max() <= SAME_MM
    assert (read[0].kind, read[0].technology, read[0].parts) == ("y_joint", "arc", ("a", "b"))
    (side,) = read[0].sides
    assert (side.throat_mm, side.section, side.stitch.length_mm) == (4.0, "Fillet", 20.0)
    taken = run_here("welds", folder, "-o", welds / "welds.json", "--xmcf", file)
    assert taken.returncode == 0, taken.stderr
    again = (welds / "welds.json").read_text()
    assert '"from": "file",\n     "of": "w.xml"' in again
    kept = run_here("welds", folder, "-o", welds / "welds.json")  # the file's values stay without the option
    assert kept.returncode == 0
    assert (welds / "welds.json").read_text() == again
    assert "exists" in run_here("welds", folder, "--write-xmcf", file).stderr


def test_the_edges_at_the_welds_of_a_file_are_picked():
    points = "0 0 0;10 0 0;10 20 0"
    assert places_of(parse_xmcf(xmcf(points=points), path="x"), file="x") == (
        "5.000000,0.000000,0.000000",
        "10.000000,10.000000,0.000000",
    )
    with pytest.raises(InputError, match="has no weld seam"):
        places_of((), file="x")


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample files of xMCF are not here")
def test_the_sample_files_of_the_working_group_are_read_or_refused_in_one_line():
    files = sorted((SAMPLES / "test_suite").rglob("*.xml"))
    assert len(files) == 195
    for file in files:
        with nullcontext() if file.parent.name == "valid_files" else suppress(FormatError):
            read_xmcf(file)


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample files of xMCF are not here")
def test_what_is_written_follows_the_schema_of_the_working_group(finished_folder, tmp_path):
    xmlschema = pytest.importorskip("xmlschema")
    schema = xmlschema.XMLSchema11(str(SAMPLES / "xmcf_3_1_1.xsd"))
    folder = finished_folder()
    for number, option in enumerate(("throat_mm=4", 'stitch={"length_mm":20,"pitch_mm":50}', "job=3")):
        file = tmp_path / f"{number}.xml"
        assert run_here("welds", folder, "--all", "--set", f"W1-W2:{option}", "--write-xmcf", file).returncode == 0
        schema.validate(str(file))
