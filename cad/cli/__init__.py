"""The commands that need a CAD kernel; each does its kernel work in one child process."""
