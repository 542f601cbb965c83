"""What to touch, how the torch touches it, and what it felt: advice, touch plans, searches and their results."""
