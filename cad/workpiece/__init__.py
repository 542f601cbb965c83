"""A workpiece: a part as read, what is on it, and the main job as one function.

``workpiece``, ``features``, ``seams``
    Open a part; list its reference features; find its seams (``marked_edges``: those that a person marked or picked).
``calibrate``, ``fit_taught``
    The main job; the part of it that needs no kernel, which the picker uses too.
``advise``
    Which features to teach.
"""
