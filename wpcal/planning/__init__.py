"""Two robots on one part: the cell, what makes a plan good, and the search for the plans between which one chooses."""
