"""Work on other machines: the workers of a Dask scheduler. Nothing here is imported without ``--dask``."""
