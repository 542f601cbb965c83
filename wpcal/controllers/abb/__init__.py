"""ABB RAPID: written, read, and for two robots in step."""
