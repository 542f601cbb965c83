"""Materials and densities are read in every way that files are known to write them."""

from pathlib import Path

import pytest

from cad.step.materials import ProductMaterial, read_materials
from cad.step.part21 import index_part21
from cad.workpiece.workpiece import open_workpiece

HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('a','',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));
ENDSEC;
DATA;
#1=PRODUCT('p1','vane','',(#9));
#2=PRODUCT_DEFINITION_FORMATION('','',#1);
#3=PRODUCT_DEFINITION('','',#2,#9);
#4=PRODUCT_DEFINITION_SHAPE('','',#3);
"""
PROPERTY = """#10=PROPERTY_DEFINITION('material property','material name',#3);
#11=PROPERTY_DEFINITION_REPRESENTATION(#10,#12);
#12=REPRESENTATION('material name',(#13),#9);
#13=DESCRIPTIVE_REPRESENTATION_ITEM('{}','{}');
"""
DENSITY = """#20=PROPERTY_DEFINITION('material property','density of part',#4);
#21=PROPERTY_DEFINITION_REPRESENTATION(#20,#22);
#22=REPRESENTATION('density',(#23),#9);
#23=MEASURE_REPRESENTATION_ITEM('density measure',POSITIVE_RATIO_MEASURE({}),#24);
#24=DERIVED_UNIT((#25));
#25=DERIVED_UNIT_ELEMENT(#26,1.);
#26=({}MASS_UNIT()NAMED_UNIT(*));
"""


def materials_of(data: str) -> dict[str, ProductMaterial]:
    return read_materials(index_part21(f"{HEAD}{data}ENDSEC;\nEND-ISO-10303-21;\n".encode(), name="a.step"))


@pytest.mark.parametrize(
    ("data", "texts"),
    [
        ("#10=MATERIAL_DESIGNATION('Plywood',(#3));\n", ("Plywood",)),
        (PROPERTY.format("Steel", "S235"), ("Steel", "S235")),
        (PROPERTY.replace("material property", "user defined attribute").format("Werkstoff", "1.4301"), ("1.4301",)),
        (
            "#10=GENERAL_PROPERTY('','Material','');\n#11=GENERAL_PROPERTY_ASSOCIATION('','',#10,#12);\n"
            "#12=PROPERTY_DEFINITION('','',#4);\n#13=PROPERTY_DEFINITION_REPRESENTATION(#12,#14);\n"
            "#14=REPRESENTATION('',(#15),#9);\n#15=DESCRIPTIVE_REPRESENTATION_ITEM('','Rubber');\n",
            ("Rubber",),
        ),
        (
            "#10=PRODUCT('AMS 4928','Titanium 6-4','',(#9));\n#11=PRODUCT_DEFINITION_FORMATION('','',#10);\n"
            "#12=PRODUCT_DEFINITION('','',#11,#9);\n#13=MAKE_FROM_USAGE_OPTION('material','','',#3,#12,1,'',$);\n",
            ("AMS 4928", "Titanium 6-4"),
        ),
    ],
)
def test_a_material_is_found(data: str, texts: tuple[str, ...]) -> None:
    assert materials_of(data)["vane"].texts == texts


@pytest.mark.parametrize("text", ["", "Material <not specified>", "Generic", "none"])
def test_no_material_is_not_a_material(text: str) -> None:
    data = PROPERTY.replace("material property", "attribute").format("Material", text)
    assert all("not specified" in one for found in materials_of(data).values() for one in found.texts)


@pytest.mark.parametrize(
    ("number", "unit", "density"),
    [
        ("7850.", "", 7850.0),
        ("0.65", "", 650.0),
        ("7.85E-6", "", 7850.0),
        ("0.284", "CONVERSION_BASED_UNIT('POUND',#9)", 7861.1),
    ],
)
def test_a_density_is_found_in_any_unit(number: str, unit: str, density: float) -> None:
    assert materials_of(DENSITY.format(number, unit))["vane"].density_kg_m3 == pytest.approx(density, rel=0, abs=0.1)


def test_two_products_of_one_name_and_different_materials_say_nothing() -> None:
    other = "#30=PRODUCT('p2','vane','',(#9));\n"
    assert materials_of("#10=MATERIAL_DESIGNATION('Plywood',(#3));\n" + other) == {}


def test_the_materials_of_a_real_part_reach_its_solids(shared_step: Path) -> None:
    facts = open_workpiece(shared_step / "dm1-id-214.stp").graph.solid_facts
    assert {fact.materials[1] for fact in facts} == {"Titanium 6-4", "Greek Ascoloy", "Inconel 718"}
    assert {round(fact.density_kg_m3 or 0.0) for fact in facts} == {4432, 7895, 8228}
