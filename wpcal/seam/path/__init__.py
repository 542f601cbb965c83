"""From pieces of edges to seams with frames: chained, directed, cut into steps, turned to the free side."""
