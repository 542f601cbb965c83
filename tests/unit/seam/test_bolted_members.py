"""Members that are bolted are not welded where the bolts press them together, and are elsewhere."""

from dataclasses import replace

import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.solid_facts import SolidFacts
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.judge.doubted import why_none_is_taken, why_nothing_is_found, would_be_taken
from wpcal.seam.limits import Level
from wpcal.seam.member.clamped import find_bolt_holes, find_clamps
from wpcal.seam.member.note import Member, take_members
from wpcal.seam.options import Judging


def seams_of(name: str, **judging: object) -> tuple[Seam, ...]:
    return saved_seams(name, SeamOptions(judging=Judging(**judging)))


def welded(seams: tuple[Seam, ...]) -> dict[tuple[str, ...], float]:
    """Return the length of the accepted seams by the solids that they join, mm."""
    found: dict[tuple[str, ...], float] = {}
    for seam in seams:
        if seam.accepted:
            found[tuple(sorted(seam.solids))] = found.get(tuple(sorted(seam.solids)), 0.0) + seam.length_mm
    return {solids: round(length, 3) for solids, length in found.items()}


@pytest.mark.parametrize("name", ["holes-in-line", "slots-in-line"])
def test_sheets_whose_holes_line_up_are_bolted(name: str) -> None:
    seams = seams_of(name)
    assert welded(seams) == {}
    assert any("2 holes of the two members line up here" in why for seam in seams for why in seam.against)
    sides = 4 * 20.0 if name == "slots-in-line" else 0.0  # a slot of 31 mm is longer than the nozzle is wide
    assert welded(seams_of(name, level=Level.GENEROUS)) == {("high", "low"): 200.0 + sides}


@pytest.mark.parametrize("name", ["one-hole-in-line", "holes-apart"])
def test_one_hole_and_holes_that_do_not_line_up_leave_a_lap_joint_welded(name: str) -> None:
    assert welded(seams_of(name)) == {("high", "low"): 200.0}


def test_no_seam_runs_round_inside_a_covered_hole() -> None:
    seams = seams_of("covered-holes")
    assert welded(seams) == {("block", "foot"): 440.0}
    assert sum("it runs round inside a hole of 11 mm that the other member covers" in s.against for s in seams) == 2


def test_a_ring_over_a_hole_is_welded() -> None:
    assert welded(seams_of("ring-over-hole")) == {("ring", "sheet"): pytest.approx(125.664, rel=0, abs=0.001)}


def test_a_gusset_with_holes_stays_welded_to_its_plate_and_the_strap_on_it_does_not() -> None:
    assert welded(seams_of("gusset-with-holes")) == {("gusset", "plate"): 320.0}


def test_a_panel_that_is_bolted_to_brackets_is_not_welded_to_their_post() -> None:
    seams = seams_of("panel-on-brackets")
    assert welded(seams) == {("bracket low", "post"): 60.0, ("bracket high", "post"): 60.0}
    assert [seam.length_mm for seam in seams if seam.wrap_of] == pytest.approx([6.0] * 4)  # the ends of the brackets
    assert any("a weld here would fix the bolts" in why for seam in seams for why in seam.against)


def test_a_slot_has_two_axes_and_a_hole_one() -> None:
    graph = saved_graph("slots-in-line")
    holes = find_bolt_holes(graph, TrimmedFaces.of(graph))
    lengths = sorted(float(abs(holes.end[k] - holes.o[k]).sum()) for k in range(len(holes)))
    assert lengths == pytest.approx([0.0, 0.0, 20.0, 20.0], rel=0, abs=1e-9)
    assert len(find_clamps(holes, {})) == 2


def test_what_a_person_says_counts_whatever_the_evidence() -> None:
    said = seams_of("holes-in-line", weld=("lo?", "HIGH"))
    assert welded(said) == {("high", "low"): 200.0}
    assert welded(seams_of("gusset-with-holes", not_welded=("gus*",))) == {}
    assert welded(seams_of("gusset-with-holes", not_welded=("*",), weld=("plate", "gusset"))) == {
        ("gusset", "plate"): 320.0
    }


def test_a_name_that_fits_no_solid_is_one_line_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"has the name 'gussset'; the nearest are gusset"):
        seams_of("gusset-with-holes", not_welded=("gussset",))


def members_with(*facts: SolidFacts) -> list[Member]:
    graph = replace(saved_graph("joint-tee"), solid_facts=facts)
    return list(take_members(graph, TrimmedFaces.of(graph), Judging()).notes.members)


def test_materials_and_densities_in_the_file_say_what_is_not_metal() -> None:
    one, other = members_with(SolidFacts(materials=("Birch plywood",)), SolidFacts(density_kg_m3=650.0))
    assert (one.taken_as, one.why) == ("wood", ("material: Birch plywood",))
    assert (other.taken_as, other.why) == ("wood, plastic or foam", ("density 650 kg/m³",))
    steel, unset = members_with(SolidFacts(materials=("S355J2",)), SolidFacts(density_kg_m3=1000.0))
    assert (steel.taken_as, steel.findings) == ("steel", ())
    assert unset.findings == ()


def test_steel_is_not_welded_to_aluminium_and_is_to_stainless_steel() -> None:
    for metal, accepted in (("EN AW-6082", False), ("1.4301", True)):
        facts = (SolidFacts(materials=("S355",)), SolidFacts(materials=(metal,)))
        seams = detect_seams(replace(saved_graph("joint-tee"), solid_facts=facts))
        assert {seam.accepted for seam in seams if seam.length_mm > 100.0} == {accepted}


def test_a_name_above_counts_unless_it_is_above_all_solids() -> None:
    motor = SolidFacts(path=("press", "Motor", "S0"), products=("press", "Motor"))
    frame = SolidFacts(path=("press", "frame", "S1"), products=("press", "frame"))
    one, other = members_with(motor, frame)
    assert (one.taken_as, one.why) == ("a motor, a gearbox or a cylinder", ("name above: Motor",))
    assert other.findings == ()
    whole = replace(motor, path=("Motor", "S0"), products=("Motor",))
    assert all(not member.findings for member in members_with(whole, replace(whole, path=("Motor", "S1"))))


def test_a_counterbore_over_a_hole_lines_up_too() -> None:
    seams = seams_of("counterbored-cap")
    assert welded(seams) == {}


def test_a_part_on_which_all_is_doubted_says_what_would_take_it() -> None:
    seams = seams_of("holes-in-line")
    (told,) = why_none_is_taken(seams)
    assert told.code == "only-doubted"
    assert (
        "no seam is taken, but 4 candidates of 200 mm might be welds: high + low (4 seams, 200 mm): 2 holes"
        in told.message
    )
    assert "--generous takes all of them, --weld high --weld low those of the first pair" in told.message
    assert set(told.ids) == {seam.name for seam in would_be_taken(seams)}
    assert welded(seams_of("holes-in-line", weld=("high", "low"))) == {("high", "low"): 200.0}
    assert why_none_is_taken(seams_of("one-hole-in-line")) == []


def test_a_part_without_a_seam_says_why_in_one_line_and_what_would_change_it() -> None:
    seams = seams_of("one-hole-in-line", not_welded=("*",))
    (told,) = why_nothing_is_found(seams, 2, 0.5)
    assert told.code == "no-seam"
    assert "you said that a solid is not welded" in told.message
    assert "--weld" in told.message
    assert why_nothing_is_found(seams_of("one-hole-in-line"), 2, 0.5) == []
    (told,) = why_nothing_is_found((), 3, 0.5)
    assert "no two of the 3 solids touch" in told.message
    assert "--gap-mm" in told.message
    assert why_nothing_is_found((), 1, 0.5) == []
