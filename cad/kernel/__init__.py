"""The CAD kernel (OCP: Open CASCADE in Python) and all that has to be known about it.

``call``
    Kernel exceptions become `KernelError`; settings of the kernel are restored after use.
``topology``, ``geometry``
    The parts of a shape (its faces, edges, vertices), and what they measure.
``to_brep``, ``canonical``, ``section``
    Shapes as arrays (`wpcal.brep.BrepGraph`); B-splines that are simple surfaces; curves where solids overlap.
``tessellate``, ``visible_lines``
    Shapes as triangles, and as the lines that are visible from one side.
``xcaf``
    Labels of a STEP document: names, colours, layers.
``primitives``
    Boxes, cylinders and prisms, for sample parts.
``child``, ``child_main``
    Run a function in a child process, because the kernel can crash: the two sides.
``plain_data``, ``plain_columns``, ``plain_types``, ``frames``
    What passes between them.

Importing a module of this package loads the kernel (0.5 s), except for these four and `system_libraries`. Modules that
also run in the parent process of a command therefore import the others inside functions.
"""
