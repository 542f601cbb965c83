"""Whether a candidate is a weld: the evidence, fasteners, the reach of a torch."""
