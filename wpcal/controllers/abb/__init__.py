"""ABB: RAPID modules."""

from wpcal.controllers.registry import Controller

RAPID = Controller(
    name="rapid",
    title="ABB RAPID: NAME.mod with wobjdata and robtargets",
    writer="wpcal.controllers.abb.write:write_rapid",
    touch_writer="wpcal.controllers.abb.touch:_RapidTouches.written",
    touch_results_reader="wpcal.controllers.abb.touch:read_rapid_results",
    touch_results=("*.mod",),
    suffixes=(".mod", ".prg", ".sys"),
    reader="wpcal.controllers.abb.read:READER",
    sync_writer="wpcal.controllers.abb.two_robots:write_sync_rapid",
    coordinated_writer="wpcal.controllers.abb.two_robots:write_coordinated_rapid",
    brands=("abb",),
    grammar="wpcal.controllers.abb.read:GRAMMAR",
    run="wpcal.controllers.abb.run:Interpreter",
    program_suffixes=(".mod", ".prg", ".sys"),
    takes_arcs=True,
    takes_plans=True,
    takes_zones=True,
    welds_alone=True,
)
