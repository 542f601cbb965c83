"""Programs, not tests: one needs atheris, the other loads the CAD kernel."""

collect_ignore = ["with_atheris.py", "kernel.py", "chain.py"]
