"""FANUC: TP programs as ASCII."""

from wpcal.controllers.registry import Controller

FANUC = Controller(
    name="fanuc",
    title="FANUC TP: NAME.ls and one .ls per seam, relative to a user frame",
    writer="wpcal.controllers.fanuc.write:write_fanuc",
    touch_writer="wpcal.controllers.fanuc.touch:_TpTouches.written",
    touch_results_reader="wpcal.controllers.fanuc.touch:read_fanuc_results",
    touch_results=("posreg.va", "numreg.va"),
    coordinated_writer="wpcal.controllers.fanuc.two_robots:write_coordinated_fanuc",
    holder_on_line=True,
    coordinates_arcs=False,
    suffixes=(".ls", ".va", ".dg"),
    reader="wpcal.controllers.fanuc.read:READER",
    grammar="wpcal.controllers.fanuc.read:GRAMMAR",
    run="wpcal.controllers.fanuc.run:Interpreter",
    program_suffixes=(".ls",),
    takes_arcs=True,
    takes_plans=True,
    welds_alone=True,
)
