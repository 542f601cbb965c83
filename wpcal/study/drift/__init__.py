"""What changes from job to job of one part: control charts, sudden shifts, and their likely causes.

`read_drift_jobs` reads folders of ``wpcal batch``; `watch_part` works on arrays only.
"""

from wpcal.study.drift.jobs import PartJobs, read_drift_jobs
from wpcal.study.drift.watch import PartDrift, watch_part

__all__ = ["PartDrift", "PartJobs", "read_drift_jobs", "watch_part"]
