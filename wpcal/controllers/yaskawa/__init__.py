"""Yaskawa: INFORM jobs."""

from wpcal.controllers.registry import Controller

INFORM = Controller(
    name="inform",
    title="Yaskawa INFORM: NAME.jbi and one .jbi per seam, relative to a user frame",
    writer="wpcal.controllers.yaskawa.write:write_inform",
    touch_writer="wpcal.controllers.yaskawa.touch:_InformTouches.written",
    touch_results_reader="wpcal.controllers.yaskawa.touch:read_inform_results",
    touch_results=("var.dat",),
    suffixes=(".jbi",),
    reader="wpcal.controllers.yaskawa.read:READER",
    variables=("var.dat",),
    sync_writer="wpcal.controllers.yaskawa.two_robots:write_sync_inform",
    coordinated_writer="wpcal.controllers.yaskawa.two_robots:write_coordinated_inform",
    brands=("yaskawa", "motoman"),
    grammar="wpcal.controllers.yaskawa.read:GRAMMAR",
    run="wpcal.controllers.yaskawa.run:Interpreter",
    program_suffixes=(".jbi",),
    takes_arcs=True,
    takes_plans=True,
    welds_alone=True,
)
