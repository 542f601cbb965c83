"""The CAD kernel: its odd exceptions, casts and collections, its child process, and its shapes as arrays."""
