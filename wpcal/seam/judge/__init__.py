"""Whether a candidate is a weld: the findings, fasteners, the reach of a torch."""
