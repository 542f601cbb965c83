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
    ("command", "modules", "allowed"),
    [
        ("seams", ["cad.workpiece.seams", "wpcal.seam.record"], set()),
        ("calibrate", ["cad.batch.recorded"], {"scipy.special"}),
    ],
)
def test_neither_the_options_of_a_command_nor_its_small_parts_load_scipy(command, modules, allowed) -> None:
    (entry,) = entry_points(group="wpcal.commands", name=command)
    module, name = entry.value.split(":")
    script = (
        f"import sys; from importlib import import_module; import_module({module!r}).{name}.params\n"
        f"for each in {['cad.cli.kernel_work', 'cad.work.child', *modules]}: import_module(each)\n"
        "heavy = ('special', 'optimize', 'sparse', 'spatial', 'linalg', 'ndimage', 'stats', 'interpolate')\n"
        f"found = {{f'scipy.{{each}}' for each in heavy}} & set(sys.modules) - {allowed}\n"
        "sys.exit(', '.join(found))"
    )
    done = subprocess.run([sys.executable, "-c", script], stderr=subprocess.PIPE, text=True, check=False)
    assert done.stderr.strip() == ""


def test_a_missing_libgl_says_what_to_type() -> None:
    with pytest.raises(InputError, match="sudo apt-get install libgl1"), libgl_explained():
        raise ImportError("libGL.so.1: cannot open shared object file: No such file or directory")


def test_any_other_failed_import_stays_what_it_is() -> None:
    with pytest.raises(ImportError, match="nothing else"), libgl_explained():
        raise ImportError("nothing else")
