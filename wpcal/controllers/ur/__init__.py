"""Universal Robots: URScript programs."""

from wpcal.controllers.registry import Controller

URSCRIPT = Controller(
    name="urscript",
    title="Universal Robots: NAME.script with the part's frame and poses",
    writer="wpcal.controllers.ur.write:write_urscript",
    touch_writer="wpcal.controllers.ur.touch:_ScriptTouches.written",
    touch_results_reader="wpcal.controllers.ur.touch:read_urscript_results",
    touch_results=("*.log", "*.txt"),
    brands=("ur", "universal-robots"),
    grammar="wpcal.controllers.ur.grammar:GRAMMAR",
    run="wpcal.controllers.ur.run:Interpreter",
    program_suffixes=(".script",),
    takes_arcs=True,
    takes_plans=True,
    takes_zones=True,
)
