"""What the languages of all controllers have in common: names, digits, templates, and the grammar to read them back."""
