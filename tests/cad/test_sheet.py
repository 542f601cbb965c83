"""The teach sheet of the samples: what a person needs is on it, where it belongs."""

import io
import json
import re
from pathlib import Path

import ezdxf
import numpy as np
import pytest

from cad.sheet import SheetOptions, make_sheet
from cad.sheet.draw import Pen, SheetRow, draw_views
from cad.sheet.fonts import require_font
from cad.sheet.make import _new_document
from cad.sheet.paper import A3, A4, lay_out
from cad.sheet.touches import read_touches_to_make, touches_of_plan
from cad.sheet.views import ISO, part_lines, project_views
from cad.sheet.welds import read_listed_welds
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from wpcal.core.errors import FormatError, GeometryError, InputError
from wpcal.taught.features import feature_named
from wpcal.touch.searches.record import read_touch_plan

ROOT = Path(__file__).parents[2]
TEE = ROOT / "fixtures" / "tee" / "tee.step"
FRAME = ROOT / "fixtures" / "frame" / "frame.step"
REAL = ROOT.parent / "shared" / "step"
NAMES = ("V2", "V4", "V16", "H2")
SAME_MM = 1e-6  #: Lines come from triangles whose corners are the exact corners of the part.
PAPER_MM = 1e-9  #: Places on paper are a product and a sum.


@pytest.fixture
def tee(sample_part):
    return sample_part("tee")


def views_of(workpiece, names):
    p = np.array([feature_named(workpiece.features, name).p_mm for name in names])
    return project_views(workpiece.graph, part_lines(workpiece), p), p


def test_views_show_the_outline_of_the_part(tee):
    """The tee is 200 by 120 by 90: each orthogonal view has two of these sizes."""
    views, _ = views_of(tee, NAMES)
    sizes = [view.box[1] - view.box[0] for view in views[:3]]
    np.testing.assert_allclose(sizes, [[200, 90], [120, 90], [200, 120]], rtol=0, atol=SAME_MM)


def test_hidden_lines_are_not_drawn(tee):
    """From the front the plate hides nothing but the web's foot and the holes: a rectangle and three sides of one."""
    front = views_of(tee, NAMES)[0][0]
    lengths = np.linalg.norm(front.segments[:, 1] - front.segments[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(2 * (200 + 10) + 150 + 2 * 80, rel=0, abs=SAME_MM)


def test_a_point_behind_the_web_is_told_from_those_in_sight(tee):
    iso = views_of(tee, NAMES)[0][3]
    assert iso.axes is ISO
    assert iso.is_seen.tolist() == [True, True, False, True]
    top = views_of(tee, ("V2", "H1"))[0][2]
    assert top.is_seen.all()


@pytest.mark.parametrize("paper", few([A3, A4], 1))
@pytest.mark.parametrize(
    ("part", "names"),
    few(
        [
            (TEE, NAMES),
            (FRAME, ("V3", "V5", "V57", "V63", "V1", "V60")),
            (REAL / "nist_ctc_05_asme1_ap242-e1.stp", ("V1", "V20", "V40", "H3", "H7", "H9", "C5", "M9")),
        ],
        2,
    ),
)
def test_everything_is_inside_the_frame_and_labels_do_not_collide(part, names, paper, golden):
    if not part.is_file():
        pytest.skip("the shared STEP files are not beside the project")
    require_font()
    layout = lay_out(paper, views_of(open_workpiece(part), names)[0], len(names))
    for place in layout.places:
        drawn = place.on_paper(np.concatenate([place.view.segments.reshape(-1, 2), place.view.p]))
        assert (drawn >= [paper.margin, layout.table.top]).all()
        assert (drawn <= [paper.frame.right, paper.frame.top]).all()
    front, left, top = layout.places[:3]
    z, x = front.on_paper(front.view.p)[:, 1], front.on_paper(front.view.p)[:, 0]
    np.testing.assert_allclose(left.on_paper(left.view.p)[:, 1], z, rtol=0, atol=PAPER_MM)
    np.testing.assert_allclose(top.on_paper(top.view.p)[:, 0], x, rtol=0, atol=PAPER_MM)
    rows = [SheetRow(str(k), name) for k, name in enumerate(names, 1)]
    for labels in draw_views(Pen(_new_document().modelspace(), paper), layout, rows):
        for i, a in enumerate(boxes := [label.box for label in labels]):
            assert not any(a.x < b.right and b.x < a.right and a.y < b.top and b.y < a.top for b in boxes[i + 1 :])
    golden([layout, [draw_views(Pen(_new_document().modelspace(), paper), layout, rows)]])


def test_the_dxf_holds_names_numbers_coordinates_and_the_hash(tee):
    sheet = make_sheet(tee, options=SheetOptions(".dxf", names=NAMES))
    document = ezdxf.read(io.StringIO(sheet.data.decode()))
    assert not document.audit().has_errors
    assert document.header["$INSUNITS"] == 4
    texts = [text.dxf.text for text in document.modelspace().query("TEXT")]
    for name in NAMES:
        assert texts.count(name) == 5  # in four views and in the table
    assert {"200.000", "120.000", "180.000"} <= set(texts)
    digest = sheet.record["part"]["sha256"]
    assert digest[:32] in " ".join(texts)
    assert digest[32:] in texts
    assert any("scale 1:2" in text for text in texts)


@pytest.mark.deep
def test_points_are_those_that_advise_picks(tee):
    from cad.workpiece.advise import AdviseOptions, advise_points
    from wpcal.seam import SeamOptions

    advised = advise_points(tee, options=AdviseOptions(points=5), seam_options=SeamOptions())
    sheet = make_sheet(TEE, options=SheetOptions(".dxf", count=5))
    assert tuple(point["name"] for point in sheet.record["points"]) == advised.chosen.names


@pytest.mark.parametrize(
    ("suffix", "start"), few([(".svg", b"<?xml"), (".pdf", b"%PDF"), (".png", b"\x89PNG"), (".dxf", b"  0")], 1)
)
def test_each_format_is_written_and_twice_the_same(tee, suffix, start):
    options = SheetOptions(suffix, A4, names=NAMES)
    first = make_sheet(tee, options=options).data
    assert first.startswith(start)
    assert make_sheet(TEE, options=options).data == first


def test_the_svg_has_the_size_of_the_paper(tee):
    head = make_sheet(tee, options=SheetOptions(".svg", A4, names=NAMES)).data[:300].decode()
    assert re.search(r'width="297mm" height="210mm"', head)


def test_what_does_not_fit_or_exist_is_refused(tee):
    with pytest.raises(InputError, match="no feature 'V99'"):
        make_sheet(tee, options=SheetOptions(".dxf", names=("V99",)))
    many = tuple(feature.name for feature in tee.features[: A4.most_points + 1])
    with pytest.raises(InputError, match=f"A4 has room for {A4.most_points} points"):
        make_sheet(tee, options=SheetOptions(".dxf", A4, names=many))
    from build123d import Box

    with pytest.raises(GeometryError, match="or name the features"):
        make_sheet(Box(10, 20, 30), options=SheetOptions(".dxf"))


def arrows_of(sheet):
    """The lines of arrows in a DXF sheet, each from its tail to its tip, on paper: barbs are shorter."""
    document = ezdxf.read(io.StringIO(sheet.data.decode("utf-8")))
    lines = [line for line in document.modelspace().query("LINE") if line.dxf.layer == "POINTS"]
    pairs = np.array([[[*line.dxf.start][:2], [*line.dxf.end][:2]] for line in lines])
    return pairs[np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1) > 1.5 * A3.text]


def test_touches_of_a_plan_are_drawn_with_arrows_in_their_direction(tee):
    plan = read_touch_plan(TEE.parent / "touches_plan")
    sheet = make_sheet(tee, options=SheetOptions(".dxf", touches=touches_of_plan(plan)))
    points = sheet.record["points"]
    assert [point["name"] for point in points] == [search.name for search in plan.searches]
    for point, search in zip(points, plan.searches, strict=True):
        np.testing.assert_allclose(point["way"], search.direction, rtol=0, atol=SAME_MM)
    assert points[7]["words"] == "hole H1, wire side, 6 mm"
    arrows = arrows_of(sheet)
    # T1 to T3 go down: not in the view from above. T4, T5 and T8 go along y: not from the front. T6 and T7 along x.
    assert len(arrows) == 3 * 3 + 3 * 3 + 2 * 3
    way = (arrows[:, 1] - arrows[:, 0]) / np.linalg.norm(arrows[:, 1] - arrows[:, 0], axis=1)[:, None]
    assert np.sum(np.abs(way @ [0.0, -1.0] - 1.0) < SAME_MM) == 3 + 3 + 3  # T1 to T3 in front, left and iso


def test_touches_of_a_table_come_against_their_faces(tee):
    touches = read_touches_to_make(TEE.parent / "touches_321.csv")
    points = make_sheet(tee, options=SheetOptions(".svg", touches=touches)).record["points"]
    expected = [[0, 0, -1]] * 3 + [[0, 1, 0]] * 2 + [[1, 0, 0]]
    np.testing.assert_allclose([point["way"] for point in points], expected, rtol=0, atol=SAME_MM)
    assert points[0]["words"] == "plane of base plate"


def test_a_table_of_points_has_no_touches_and_a_row_without_a_place_is_refused(tmp_path):
    assert read_touches_to_make(TEE.parent / "taught.csv") is None
    table = tmp_path / "touched.csv"
    table.write_text("name,kind,feature,x_mm,y_mm,z_mm\nT1,plane,P8,,,\nT2,edge,,,,\n")
    with pytest.raises(FormatError, match=r"line 3.*neither a feature nor a model point"):
        read_touches_to_make(table)


def test_a_plan_or_a_list_of_another_part_is_refused(sample_part, tmp_path):
    touches, welds = touches_of_plan(read_touch_plan(TEE.parent / "touches_plan")), listed(tmp_path, 2)
    for what, asked in (("touch T1", {"touches": touches}), ("weld W1", {"welds": read_listed_welds(welds)})):
        with pytest.raises(InputError, match=rf"{what} is \d+ mm from the nearest face of this part"):
            make_sheet(sample_part("saddle"), options=SheetOptions(".svg", **asked))


def listed(tmp_path, count):
    """A list of welds of the T-joint: the two that `wpcal welds` finds, and as many more at the same places."""
    from wpcal.weld.values import WeldKind

    kinds = list(WeldKind)
    welds = [
        {
            "name": f"W{k + 1}",
            "place": {"start_part_mm": [25, y, 10], "middle_part_mm": [100, y, 10], "length_mm": 150 + 40 * (k == 1)},
            "values": {"weld": kinds[k % len(kinds)].value, "leg_mm": 6.5, "passes": k + 1, "thickness_mm": 8},
            "stretches_mm": [[0.0, 50.0], [100.0, 150.0]],
        }
        for k, y in zip(range(count), (56, 64) * count, strict=False)
    ]
    path = tmp_path / "welds.json"
    path.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": welds}))
    return path


def test_a_list_of_welds_has_their_signs_sizes_and_lengths(tee, tmp_path):
    sheet = make_sheet(tee, options=SheetOptions(".dxf", welds=read_listed_welds(listed(tmp_path, 8))))
    texts = [text.dxf.text for text in ezdxf.read(io.StringIO(sheet.data.decode())).modelspace().query("TEXT")]
    assert [(one["name"], one["welded_mm"]) for one in sheet.record["welds"]] == [(f"W{k}", 100) for k in range(1, 9)]
    assert texts.count("W3") == 5  # in four views and in the table
    assert texts.count("100") == 8
    assert {"z6.5 fillet weld", "z6.5 double-V butt weld, 5 passes"} <= set(texts)
    assert sheet.record["points"] == []
    # Seven straight welds along x are arrows in three views; W2 is longer than twice its half, so it is bent.
    arrows = arrows_of(sheet)
    assert len(arrows) == 7 * 3
    flat = arrows[np.abs(arrows[:, 0, 1] - arrows[:, 1, 1]) < SAME_MM]
    np.testing.assert_allclose(flat[:, 1, 0] - flat[:, 0, 0], 75 / 2 - 0.4 * A3.text, rtol=0, atol=SAME_MM)


@pytest.mark.deep
def test_many_welds_are_pages_of_a_pdf_and_nothing_else(tee, tmp_path):
    welds = read_listed_welds(listed(tmp_path, A4.most_points + 1))
    data = make_sheet(tee, options=SheetOptions(".pdf", A4, welds=welds)).data
    assert data.count(b"/Type /Page ") == 2
    with pytest.raises(InputError, match=rf"A4 has room for {A4.most_points} welds, got \d+; .pdf has pages"):
        make_sheet(tee, options=SheetOptions(".svg", A4, welds=welds))


def test_a_weld_without_a_place_says_how_to_get_one(tmp_path):
    path = tmp_path / "welds.json"
    path.write_text('{"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": {"leg_mm": 5}}]}')
    with pytest.raises(FormatError, match=r"weld W1: has no place; wpcal welds DIR -o welds.json adds what is missing"):
        read_listed_welds(path)
