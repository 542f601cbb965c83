"""Processes: how one is started and ended, its limits, the frames that it sends, and the plain data in them.

Three kinds use this room: the child that runs one function with the CAD kernel (`child`), the processes of a batch
(`server`, `group`, `host`), and the worker of `wpcal rpc`.
"""
