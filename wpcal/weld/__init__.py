"""What is laid into a seam: weld data with the origin of each value, beads, stitches, and weld files of others."""
