"""The `wpcal` command: one file per command, parsing apart from doing.

Nothing in the current folder is run: it may hold a customer's files.
"""

import os
import sys

PROGRAMS = ("wpcal", "wpcal.exe", "wpcal-script.py", "__main__.py")
"""Names of what runs as the command. A script of a user that imports `wpcal.cli` keeps its `sys.path`."""


def forget_working_folder() -> None:
    """Take the current folder from `sys.path` if this process is the command, unless wpcal was imported from there.

    ``python -m`` and an empty entry of PYTHONPATH put it there, before the standard library. A ``numpy.py`` that lies
    beside a customer's file would then be imported. Nothing else is imported before this is done.
    """
    if not sys.argv or os.path.basename(sys.argv[0]) not in PROGRAMS:
        return
    try:
        here = os.getcwd()
    except OSError:  # the folder was removed
        here = ""
    if here and os.path.realpath(__file__).startswith(os.path.join(os.path.realpath(here), "")):
        return
    sys.path[:] = [entry for entry in sys.path if entry not in ("", here)]


forget_working_folder()
