"""Staubli: VAL3 applications."""

from wpcal.controllers.registry import Controller

VAL3 = Controller(
    name="val3",
    title="Staubli VAL3: NAME.pjx, NAME.dtx, start.pgx with the part's frame and points",
    writer="wpcal.controllers.staubli.write:write_val3",
    brands=("staubli",),
    grammar="wpcal.controllers.staubli.grammar:GRAMMAR",
    run="wpcal.controllers.staubli.run:Interpreter",
    program_suffixes=(".dtx", ".pgx"),
    takes_arcs=True,
    takes_plans=True,
    takes_zones=True,
)
