"""Audit files: every fault of what wpcal reads and writes, with its place. Readers and schemas give the rules."""

from wpcal.controllers.audit.fault import AuditReport, Fault, FileAudit
from wpcal.controllers.audit.files import audit_path

__all__ = ["AuditReport", "Fault", "FileAudit", "audit_path"]
