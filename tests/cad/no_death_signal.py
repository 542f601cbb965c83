"""The kernel's process as on a system that sends no signal when the parent ends."""

from cad.work import child_main, own_process

if __name__ == "__main__":
    child_main.has_death_signal = own_process.has_death_signal = lambda: False
    child_main.main()
