"""Programs, not tests: one needs atheris, the others load the CAD kernel."""

collect_ignore = ["with_atheris.py", "kernel.py", "chain.py"]
