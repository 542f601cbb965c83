"""Which touches to make: searches with the least predicted error of the seams, and the safe way between them."""
