"""Pictures as SVG: a seam in its part, the section across it, torches side by side, the map of places."""
