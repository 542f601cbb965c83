"""Kawasaki: AS programs."""

from wpcal.controllers.registry import Controller

AS = Controller(
    name="as",
    title="Kawasaki AS: NAME.as with programs, the part's frame and transformation values",
    writer="wpcal.controllers.kawasaki.write:write_as",
    touch_writer="wpcal.controllers.kawasaki.touch:_AsTouches.written",
    touch_results_reader="wpcal.controllers.kawasaki.touch:read_as_results",
    touch_results=("*.as",),
    suffixes=(".as",),
    reader="wpcal.controllers.kawasaki.read:READER",
    brands=("kawasaki",),
    grammar="wpcal.controllers.kawasaki.read:GRAMMAR",
    run="wpcal.controllers.kawasaki.run:Interpreter",
    program_suffixes=(".as",),
    takes_arcs=True,
    takes_plans=True,
    welds_alone=True,
)
