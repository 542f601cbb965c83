"""Limits of the tests that name a wrong point or a wrong touch."""

FALSE_ALARM = 0.01
"""Probability, over all points of one fit, that a good point is called wrong."""

NAMED_PROBABILITY = 0.55
"""A point or pair is named as wrong if its probability is at least this. Its probability is always said with it."""

FLOOR_MM = 0.01
"""Controllers print hundredths of a millimetre: a smaller difference is not evidence of an error."""

LEAST_SIGMA_MM = 1e-6
"""A smaller stated error counts as this. No controller shows less, and the inverse square stays finite."""

CLEAR_FACTOR = 4.0
"""The best explanation is named only if every rival leaves at least this many times its sum of squares."""
