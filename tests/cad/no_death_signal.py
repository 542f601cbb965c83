"""The kernel's process as on a system that sends no signal when the parent ends."""

from cad.kernel import child_main

if __name__ == "__main__":
    child_main.has_death_signal = lambda: False
    child_main.main()
