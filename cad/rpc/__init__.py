"""`wpcal rpc`: wpcal as a child process of another program, by lines of JSON (docs/reference/rpc.md).

Two processes answer. The front (`front.py`) talks with the client: it reads lines (`client_lines.py`), checks requests
(`messages.py`, `protocol.py`), and keeps the handles. The worker (`worker.py`) holds the opened parts (`open_parts.py`)
and does what the methods say (`part_methods.py`, `command_methods.py`). A crash of the CAD kernel ends the worker only;
the front starts another one (`worker_process.py`), which opens the parts again when they are asked for.
"""
