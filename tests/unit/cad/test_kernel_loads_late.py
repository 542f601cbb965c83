"""A command starts without the CAD kernel: the child process loads it."""

import subprocess
import sys
from importlib.metadata import entry_points

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
