"""`wpcal pick`: choose features in a browser, type what the robot shows, see at once what it is worth.

`part.py` runs in the child process that reads the STEP file; after it no kernel is needed. `rows.py` is the table in
the page, `session.py` what can be done with it, `page.py` the page, `server.py` the way between them.
"""
