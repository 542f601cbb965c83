"""Wrong input for every reader, made by chance. `make fuzz` runs it long; `test_fuzz.py` runs a short part in CI."""
