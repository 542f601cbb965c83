"""The kernel is loaded late, and its system libraries are looked for first."""

import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from cad.work.system_libraries import libgl_explained
from wpcal.core.errors import InputError

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
