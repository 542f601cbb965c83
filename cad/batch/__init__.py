"""Many jobs in processes of their own, so that a crash loses one job only.

`cad.work.host` is the side of the command. It starts one server process (`cad.work.server`) that loads the CAD kernel
once. The server forks a process for every group of jobs that share a part (`cad.work.group`), and that process, when
it knows the part, forks those that run its jobs. `cad.batch.run` puts jobs, groups and results together.
"""
