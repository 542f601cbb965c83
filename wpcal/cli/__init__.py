"""The command line: one file per command. What a command does is in the other packages.

Nothing in the current folder is run: it may hold a customer's files.
"""

from wpcal.cli.working_folder import forget_working_folder

forget_working_folder()
