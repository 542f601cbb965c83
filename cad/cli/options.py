"""Options that several commands share, and where their groups are."""

from __future__ import annotations

import click

FINDING, CHOICE = "wpcal.seam.options:SeamOptions", "cad.batch.seams_asked:SeamsAsked"
BODIES, POINTS = "cad.batch.bodies_asked:BodiesAsked", "wpcal.controllers.taught_program:PointsAsked"
FITTING, REQUEST = "cad.workpiece.fit_taught:CalibrateOptions", "cad.batch.request:Request"
"""Option groups (`wpcal.cli.option_groups.takes`)."""
PART, MESH, LINES = "part", "mesh", "lines"
"""Questions of `cad.workpiece.step_file`; written out so that the help needs no NumPy."""

no_cache_option = click.option(
    "--no-cache", is_flag=True, help="Find everything anew, and keep nothing for the next command on the same file."
)
