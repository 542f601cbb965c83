"""What names say about solids, in several languages, and names of seams as they are typed: single ones and ranges."""

import pytest

from wpcal.core.errors import InputError
from wpcal.seam.member.names import read_material, read_name
from wpcal.seam.member.words import Kind
from wpcal.seam.names import seams_named, split_names

FASTENERS = (
    "Hex Nut M10 · bolt_3 · Fastener_HexNut_2 · DIN 934 - M8 · DIN125-A 8.4 · ISO 4762 M6x20 · "
    "ISO4014 · DIN EN ISO 4032 · Sechskantschraube · Unterlegscheibe · Muttern · vis CHC · écrou "
    "· rondelle plate · tornillo · tuerca · arandela · vite TCEI · dado M8 · śruba · nakrętka · "
    "螺栓 · 六角螺母 · гайка · Шайба 10 · ボルト · flange bolt · plate washer · Screw001 · M8x30 · "
    "GB/T 5782-2000 · JIS B 1180 · ГОСТ 7798 · nail · Nägel · Schraube · Rundnagel · clou · "
    "Parafuso"
)
MEMBERS = (
    "motor bracket · bearing housing · bolt flange · nut plate · cable tray · glass holder · "
    "engine hoist · Lagerbock · Motorplatte · support moteur · soporte motor · 电机座 · 轴承座 · "
    "base-left-rail · rail_low · HEA 120 · DIN 1026 U100 · EN 10219 80x80x4 · angle 50x50x5 · "
    "l-bracket · foot · post-fl · NUMBER_PLATE · wood stove · Wood Connector · Hinge · "
    "bolt-on bracket · A · S1 · Part 1 · Труба · Screw jack frame · wash plate · Platine · Handle "
    "· Nutzlast · window frame · rulman braketi · direksiyonbaglanti1 · cam follower bracket"
)
OTHERS = {
    "6204-2RS": Kind.BEARING, "608ZZ": Kind.BEARING, "Kugellager": Kind.BEARING, "roulement": Kind.BEARING,
    "轴承": Kind.BEARING, "NEMA17": Kind.DRIVE, "Motor": Kind.DRIVE, "Getriebe": Kind.DRIVE, "HGR15": Kind.GUIDE,
    "linear guide": Kind.GUIDE, "ball screw": Kind.GUIDE, "O-Ring 20x2": Kind.SEAL, "Dichtung": Kind.SEAL,
    "plywood panel": Kind.WOOD, "Sperrholzplatte": Kind.WOOD, "contreplaqué": Kind.WOOD, "sklejka": Kind.WOOD,
    "Holzbalken": Kind.WOOD, "胶合板": Kind.WOOD, "фанера": Kind.WOOD, "rubber foot": Kind.RUBBER, "Gummi": Kind.RUBBER,
    "nylon bush": Kind.PLASTIC, "POM_slider": Kind.PLASTIC, "3D printed holder": Kind.PLASTIC, "glass": Kind.GLASS,
    "Cable": Kind.CABLE, "foam block": Kind.SOFT, "Beton": Kind.STONE, "Schweißmutter M8": Kind.WELD_NUT,
    "weld nut": Kind.WELD_NUT, "DIN 929": Kind.WELD_NUT, "tyre": Kind.WHEEL, "Druckfeder": Kind.SPRING,
    "steel tube": Kind.STEEL, "Stahlplatte": Kind.STEEL, "alu profile": Kind.ALUMINIUM,
    "Edelstahlblech": Kind.STAINLESS, "battery model": Kind.DEVICE, "gearbox assembly": Kind.DRIVE,
    "lastik arka": Kind.WHEEL, "arka rulman": Kind.BEARING, "M8 cıvata": Kind.FASTENER, "zincir-sol": Kind.CABLE,
    "batarya-sag": Kind.DEVICE, "Ahşap kapak": Kind.WOOD, "Akku Modell": Kind.DEVICE, "bearing unit 2": Kind.BEARING,
}  # fmt: skip


@pytest.mark.parametrize("name", FASTENERS.split(" · "))
def test_names_of_fasteners(name: str) -> None:
    assert [hit.kind for hit in read_name(name)][:1] == [Kind.FASTENER]


@pytest.mark.parametrize("name", MEMBERS.split(" · "))
def test_names_that_say_nothing_against_welding(name: str) -> None:
    assert read_name(name) == ()


@pytest.mark.parametrize(("name", "kind"), OTHERS.items())
def test_names_of_other_things_and_materials(name: str, kind: Kind) -> None:
    assert [hit.kind for hit in read_name(name)][:1] == [kind]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("S355J2+N", Kind.STEEL), ("1.4301", Kind.STAINLESS), ("1.0038", Kind.STEEL), ("AISI 304", Kind.STAINLESS),
        ("6061-T6", Kind.ALUMINIUM), ("EN AW-6082", Kind.ALUMINIUM), ("ABS", Kind.PLASTIC), ("PA66-GF30", Kind.PLASTIC),
        ("Birch plywood", Kind.WOOD), ("Titanium 6-4", Kind.TITANIUM), ("Edelstahl", Kind.STAINLESS),
        ("Rubber, silicone", Kind.RUBBER), ("Plain Carbon Steel", Kind.STEEL), ("St 37", Kind.STEEL),
    ],
)  # fmt: skip
def test_materials_as_files_write_them(text: str, kind: Kind) -> None:
    hit = read_material(text)
    assert hit.kind is kind


@pytest.mark.parametrize("text", ["Generic", "Material <not specified>", "AMS 4928", ""])
def test_unknown_materials_say_nothing(text: str) -> None:
    assert read_material(text) is None


KNOWN = ("W1", "W2", "W5", "W6a", "W6b", "W7", "W10", "rib-2", "Rib", "rib")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("W2,W1", ["W2", "W1"]),
        ("W5-W7", ["W5", "W6a", "W6b", "W7"]),
        ("w5 - 7", ["W5", "W6a", "W6b", "W7"]),
        ("W1-W10, W2", ["W1", "W2", "W5", "W6a", "W6b", "W7", "W10"]),
        ("rib-2", ["rib-2"]),
        ("rib,RIB-2", ["rib", "rib-2"]),
        ("W6-W6", ["W6a", "W6b"]),
        ("", []),
    ],
)
def test_names_and_ranges(typed: str, meant: list[str]) -> None:
    assert list(seams_named(split_names(typed), KNOWN)) == meant


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        ("W9", "unknown seam W9; there are W1, W2"),
        ("W1-W9", "unknown seam W1-W9"),
        ("W7-W5", "W7-W5: the range runs backwards"),
        ("W6", "unknown seam W6; .*near: W6b, W6a"),
        ("RIB", "unknown seam RIB"),
        ("V1-V2", "unknown seam V1-V2"),
    ],
)
def test_what_is_no_seam_is_told(typed: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        seams_named(split_names(typed), KNOWN)
