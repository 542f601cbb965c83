"""Run `python -m wpcal`: the same command as `wpcal`."""

from wpcal.cli.main import run

run()
