"""The `wpcal` command: one file a command, parsing apart from doing."""
