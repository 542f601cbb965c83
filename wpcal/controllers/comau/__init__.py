"""Comau: PDL2 programs."""

from wpcal.controllers.registry import Controller

PDL2 = Controller(
    name="pdl2",
    title="Comau PDL2: NAME.pdl with the part's frame, positions and a routine per seam",
    writer="wpcal.controllers.comau.write:write_pdl2",
    suffixes=(".pdl",),
    reader="wpcal.controllers.comau.read:READER",
    brands=("comau",),
    grammar="wpcal.controllers.comau.read:GRAMMAR",
    run="wpcal.controllers.comau.run:Interpreter",
    program_suffixes=(".pdl",),
)
