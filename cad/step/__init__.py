"""STEP files: the text, the products, reading, moving and writing."""
