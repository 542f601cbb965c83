"""Many jobs in processes of their own, so that a crash loses one job only.

`cad.batch.host` is the side of the command. It starts one server process (`cad.batch.server`) that loads the CAD kernel
once. The server forks a process for every group of jobs that share a part (`cad.batch.group`), and that process, when
it knows the part, forks those that run its jobs. `cad.batch.run` puts jobs, groups and results together.
"""
