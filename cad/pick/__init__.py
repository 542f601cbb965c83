"""`wpcal pick`: choose features in a browser, type what the robot shows, and see the fit at once.

`part.py` runs in the child process that reads the STEP file; after that no kernel is needed. `rows.py` is the table in
the page. `shared_table.py` is the one table of all windows: it keeps the draft (`draft.py`) and saves the file.
`opening.py` chooses the rows at the start. `session.py` fits rows, `page.py` builds the page, and `server.py` connects
the page with the table and the session.
"""
