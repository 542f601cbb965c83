"""Universal Robots URScript: written."""
