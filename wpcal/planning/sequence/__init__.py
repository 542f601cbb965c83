"""One robot welds all seams of a part: how each seam can be welded, the order, the moves between, and the result."""
