"""From pieces of edges to frames: chained, directed, cut into steps."""
