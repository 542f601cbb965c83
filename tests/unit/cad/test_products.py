"""Products of a file; the kernel is loaded late, and its system libraries are looked for first."""

import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from cad.step.part21 import Part21File, index_part21
from cad.step.products import find_roots, unit_name
from cad.work.system_libraries import libgl_explained
from wpcal.core.errors import FormatError, InputError

MM = "#90=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
METRE = "#90=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));"
INCH = (
    "#90=(CONVERSION_BASED_UNIT('INCH',#91)LENGTH_UNIT()NAMED_UNIT(#93));"
    "#91=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#92);#92=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
    "#93=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"
)
INCH_COMPLEX = INCH.replace(
    "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#92)",
    "(LENGTH_MEASURE_WITH_UNIT()MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#92))",
)


def product(first: int, items: str = "#80") -> str:
    """A product with its shape: definition #first, shape representation #first+3."""
    n = first
    return (
        f"#{n}=PRODUCT_DEFINITION('design','',#{n + 4},#{n + 6});#{n + 1}=PRODUCT_DEFINITION_SHAPE('','',#{n});"
        f"#{n + 2}=SHAPE_DEFINITION_REPRESENTATION(#{n + 1},#{n + 3});#{n + 3}=SHAPE_REPRESENTATION('',({items}),#88);"
        f"#{n + 4}=PRODUCT_DEFINITION_FORMATION('','',#{n + 5});#{n + 5}=PRODUCT('p{n}','p{n}','',(#87));"
        f"#{n + 6}=PRODUCT_DEFINITION_CONTEXT('part definition',#86,'design');"
    )


def file_of(body: str, unit: str = MM) -> Part21File:
    fixed = (
        "#80=AXIS2_PLACEMENT_3D('',#81,#82,#83);#81=CARTESIAN_POINT('',(0.,0.,0.));#82=DIRECTION('',(0.,0.,1.));"
        "#83=DIRECTION('',(1.,0.,0.));#86=APPLICATION_CONTEXT('x');#87=PRODUCT_CONTEXT('',#86,'mechanical');"
        "#88=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#90))REPRESENTATION_CONTEXT('',''));"
    )
    return index_part21(f"ISO-10303-21;HEADER;ENDSEC;DATA;{fixed}{unit}{body}ENDSEC;".encode(), name="part.step")


def test_one_product_is_the_root() -> None:
    (root,) = find_roots(file_of(product(1)))
    assert (root.definition, root.representation, root.context, root.axis, root.unit_mm) == (1, 4, 88, 80, 1.0)


def test_a_component_is_no_root_and_two_products_are_two() -> None:
    usage = "#40=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','child','',#1,#11,$);"
    assert [root.definition for root in find_roots(file_of(product(1) + product(11) + usage))] == [1]
    assert [root.definition for root in find_roots(file_of(product(1) + product(11)))] == [1, 11]


def test_the_shape_of_a_use_is_no_root() -> None:
    usage = (
        "#40=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','child','',#1,#11,$);#41=PRODUCT_DEFINITION_SHAPE('','',#40);"
        "#42=SHAPE_DEFINITION_REPRESENTATION(#41,#14);"
    )
    assert [root.definition for root in find_roots(file_of(product(1) + product(11) + usage))] == [1]


def test_a_representation_without_a_placement_has_no_axis() -> None:
    (root,) = find_roots(file_of(product(1, items="#81")))
    assert root.axis is None


@pytest.mark.parametrize(
    ("unit", "length_mm", "name"),
    [(MM, 1.0, "mm"), (METRE, 1000.0, "m"), (INCH, 25.4, "inch"), (INCH_COMPLEX, 25.4, "inch")],
)
def test_the_unit_is_followed_to_its_base(unit: str, length_mm: float, name: str) -> None:
    (root,) = find_roots(file_of(product(1), unit))
    assert root.unit_mm == length_mm
    assert unit_name(root.unit_mm) == name


def test_a_unit_that_leads_in_a_circle_is_refused() -> None:
    circle = INCH.replace("#92=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));", "").replace(
        "25.4),#92", "1.),#90"
    )
    with pytest.raises(FormatError, match="length unit"):
        find_roots(file_of(product(1), circle))


def test_a_file_without_products_has_no_roots() -> None:
    assert find_roots(file_of("")) == ()


IN_THE_PARENT = (
    "cad.work.host",
    "cad.batch.jobs",
    "cad.batch.recorded",
    "cad.work.child",
    "cad.pick.server",
    "cad.sheet",
    "cad.workpiece.advise",
    "cad.workpiece.fit_taught",
)
"""Modules that commands import in their own process to prepare the work of the child and to show its result."""


def test_no_command_loads_the_kernel_before_its_child_does():
    commands = [entry.value.split(":")[0] for entry in entry_points(group="wpcal.commands")]
    modules = [module for module in (*commands, *IN_THE_PARENT) if module.startswith("cad.")]
    assert len(modules) > len(IN_THE_PARENT)
    script = (
        "import sys\n"
        "from importlib import import_module\n"
        f"for name in {modules!r}:\n"
        "    import_module(name)\n"
        "    assert not {'OCP', 'build123d'} & set(sys.modules), name\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.parametrize(
    ("command", "work", "allowed"),
    [("seams", "cad.workpiece.seams", set()), ("calibrate", "cad.batch.recorded", {"scipy.special"})],
)
def test_neither_options_nor_small_parts_load_scipy(command: str, work: str, allowed: set[str]) -> None:
    module, name = entry_points(group="wpcal.commands")[command].value.split(":")
    script = (
        f"import sys, {work}, cad.cli.kernel_work, cad.work.child, {module} as of; of.{name}.params\n"
        "heavy = ('special', 'optimize', 'sparse', 'spatial', 'linalg', 'ndimage', 'stats', 'interpolate')\n"
        f"sys.exit(', '.join({{f'scipy.{{each}}' for each in heavy}} & set(sys.modules) - {allowed}))"
    )
    assert subprocess.run([sys.executable, "-c", script], stderr=subprocess.PIPE, check=False).stderr.strip() == b""


def test_a_missing_libgl_says_what_to_type() -> None:
    with pytest.raises(InputError, match="sudo apt-get install libgl1"), libgl_explained():
        raise ImportError("libGL.so.1: cannot open shared object file: No such file or directory")


def test_any_other_failed_import_stays_what_it_is() -> None:
    with pytest.raises(ImportError, match="nothing else"), libgl_explained():
        raise ImportError("nothing else")
