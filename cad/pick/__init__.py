"""`wpcal pick`: choose features in a browser, type what the robot shows, and see the fit at once.

`part.py` runs in the child process that reads the STEP file; after that no kernel is needed. `rows.py` is the table in
the page, `session.py` fits and saves it, `page.py` builds the page, and `server.py` connects page and session.
"""
