"""KUKA: KRL programs and data lists."""

from wpcal.controllers.registry import Controller

KRL = Controller(
    name="krl",
    title="KUKA KRL: NAME.src and NAME.dat with FRAME and E6POS",
    writer="wpcal.controllers.kuka.write:write_krl",
    touch_writer="wpcal.controllers.kuka.touch:_KrlTouches.written",
    touch_results_reader="wpcal.controllers.kuka.touch:read_krl_results",
    touch_results=("*.dat",),
    suffixes=(".dat",),
    reader="wpcal.controllers.kuka.read:READER",
    coordinated_writer="wpcal.controllers.kuka.two_robots:write_coordinated_krl",
    holder_on_line=True,
    brands=("kuka",),
    grammar="wpcal.controllers.kuka.read:GRAMMAR",
    run="wpcal.controllers.kuka.run:Interpreter",
    program_suffixes=(".src", ".dat"),
    takes_arcs=True,
    takes_plans=True,
    takes_zones=True,
    welds_alone=True,
)
