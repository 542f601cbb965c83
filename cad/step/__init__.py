"""STEP files: read as solids, moved, written and compared.

With the kernel:

``read``, ``xcaf_tree``, ``solids``
    A file as placed, named solids; the product tree of the kernel's document; the solids of one product, sewn from
    loose faces if necessary.
``tessellated``
    Faces that hold triangles only (tessellated AP242 files).
``write``, ``compare``
    A part moved, by one of three ways, and what was written compared with what was read.
``new_file``
    A new file of named, coloured solids.

On the text of the file, without the kernel:

``open_text``
    What can be refused without the kernel: not a STEP file, empty, cut off.
``part21``, ``part21_values``
    Where each statement is, and what its values are (ISO 10303-21).
``products``
    Root products, components and units.
``append``, ``append_colors``, ``append_seams``, ``bake``
    Entities added at the end of the data (a placement, colours, seams), or coordinates changed in place.
"""
