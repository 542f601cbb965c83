"""The start of `wpcal` and of `python -m wpcal`."""

import signal


def run() -> None:
    """Run the command line and exit (`wpcal.cli.main.run`).

    Before its commands are imported, and when all is said, Ctrl-C ends this process at once, as SIGTERM does: nothing
    is begun, and there is nothing to tell.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from wpcal.cli.main import run as run_commands

    run_commands()


if __name__ == "__main__":
    run()
