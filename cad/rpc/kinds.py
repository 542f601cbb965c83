"""First bytes of the lines that the worker sends to the front."""

BEGUN, PROGRESS, KNOWN = b"B", b"P", b"K"
"""A request begins; a line of progress; what is known of a part."""
FINAL = b"F"  #: Files are put in place: the request cannot be cancelled any more.
ANSWER, CANCELLED = b"A", b"C"
"""The line that answers a request: its own, or that it was cancelled before anything was put in place."""
