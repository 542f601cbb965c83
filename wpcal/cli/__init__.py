"""The `wpcal` command: one file per command, parsing apart from doing."""
