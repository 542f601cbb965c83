"""The version of wpcal, for its records and for the build."""

__version__ = "0.1.1"
