"""What the options that several commands share say in the help, and their types: one name has one meaning everywhere.

The first sentence is the same in every command; a command may add another one.
"""

from __future__ import annotations

import functools
from pathlib import Path

import click

JSON_HELP = "Print JSON on stdout"
FORCE_HELP = "Replace what exists"  #: A command adds what it writes, after a colon.

DETAILS_HELP = "Also print the objective, its lower bound and the gap, and the correction in radians."

ONLY_HELP = "Only these seams: names and ranges."
ROBOT_HELP = "Arm: the name of a shipped arm, an arm file or a URDF file."
TOOL_METAVAR = "X,Y,Z[,RX,RY,RZ]|TOOL.json"
TOOL_HELP = (
    "Tool centre point in the flange frame: numbers in mm and degrees (R = Rz Ry Rx), or the file of `wpcal tcp`."
)
XMCF_HELP = "Welds of an xMCF file (ISO/PAS 8329, coordinates of the part)"
DASK_HELP = "Work on the workers of this Dask scheduler"

_PATH = click.Path(path_type=Path)
path_argument = functools.partial(click.argument, type=_PATH)
"""`click.argument` that is a `Path`."""
path_option = functools.partial(click.option, type=_PATH)
"""`click.option` that is a `Path`."""
