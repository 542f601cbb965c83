"""The files of a result folder that several rooms read."""

CALIBRATION_FILE, SEAMS_FILE, PART_FILE = "calibration.json", "seams.json", "part.glb"
TABLE_FILE, PAGE_FILE = "seams.csv", "report.html"
CALIBRATION_SCHEMA = "wpcal/calibration/1"
JOB_FILE, JOB_SCHEMA = "job.json", "wpcal/job/1"
"""The request for the results, which `wpcal verify` does again, and the SHA-256 of every file of the folder."""
SUMMARY_FILE, SUMMARY_SCHEMA, SUMMARY_TABLE = "summary.jsonl", "wpcal/job-summary/1", "summary.csv"
"""What a batch writes beside the folders of its jobs: a line for each of them, and the same as a table."""
