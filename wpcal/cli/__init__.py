"""The `wpcal` command: one file per command, parsing apart from doing.

Nothing in the current folder is run: it may hold a customer's files.
"""

from wpcal.cli.working_folder import forget_working_folder

forget_working_folder()
