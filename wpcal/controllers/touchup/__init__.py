"""Points that a person corrected on the pendant: read from the changed program, and used as measurements."""
