"""What a fit shows and what it does not: criteria, evidence, blame, and the one verdict."""
