"""Two robots on one part: the cell, plans and their files, and the search for trade-off plans to choose from."""
