"""The records that wpcal writes, declared once as types; their JSON Schemas are generated from these.

A field says its type, its bounds and, where the name does not, its meaning. `schema_of` makes the JSON Schema (draft
2020-12) of a type, and `wpcal.core.record_check` reads with it. A class is found by the name that its record states.
"""

from __future__ import annotations

from collections.abc import Mapping

RECORDS: Mapping[str, str] = {
    "wpcal/calibration/1": "wpcal.records.calibration:Calibration",
    "wpcal/seams/1": "wpcal.records.seams:Seams",
    "wpcal/truth/1": "wpcal.records.seams:Truth",
    "wpcal/welds/1": "wpcal.records.welds:Welds",
    "wpcal/weld-rules/1": "wpcal.records.welds:WeldRules",
    "wpcal/arm/1": "wpcal.records.robots:Arm",
    "wpcal/torch/1": "wpcal.records.robots:Torch",
    "wpcal/torches/1": "wpcal.records.robots:Torches",
    "wpcal/tool/1": "wpcal.records.robots:Tool",
    "wpcal/cell-errors/1": "wpcal.records.robots:CellErrors",
    "wpcal/identification/1": "wpcal.records.robots:Identification",
    "wpcal/pose-plan/1": "wpcal.records.robots:PosePlan",
    "wpcal/corrected/1": "wpcal.records.robots:Corrected",
    "wpcal/cell/1": "wpcal.records.cells:Cell",
    "wpcal/cell-check/1": "wpcal.records.cells:CellCheck",
    "wpcal/place/1": "wpcal.records.cells:Place",
    "wpcal/plan/1": "wpcal.records.plans:Plan",
    "wpcal/pareto/1": "wpcal.records.plans:Pareto",
    "wpcal/weld-sequence/1": "wpcal.records.plans:WeldSequence",
    "wpcal/program/1": "wpcal.records.programs:Program",
    "wpcal/export/1": "wpcal.records.programs:Export",
    "wpcal/ros-sidecar/1": "wpcal.records.programs:RosSidecar",
    "wpcal/compas/1": "wpcal.records.programs:Compas",
    "wpcal/formats/1": "wpcal.records.programs:Formats",
    "wpcal/touchup/1": "wpcal.records.programs:TouchUp",
    "wpcal/audit/1": "wpcal.records.programs:Audit",
    "wpcal/taught/1": "wpcal.records.points:Taught",
    "wpcal/match/1": "wpcal.records.points:Match",
    "wpcal/features/1": "wpcal.records.points:Features",
    "wpcal/bodies/1": "wpcal.records.points:Bodies",
    "wpcal/pick-draft/1": "wpcal.records.points:PickDraft",
    "wpcal/sheet/1": "wpcal.records.points:Sheet",
    "wpcal/advice/1": "wpcal.records.touching:Advice",
    "wpcal/moved-advice/1": "wpcal.records.touching:MovedAdvice",
    "wpcal/touches/1": "wpcal.records.touching:Touches",
    "wpcal/batch/1": "wpcal.records.batches:Batch",
    "wpcal/job/1": "wpcal.records.batches:JobRecord",
    "wpcal/job-summary/1": "wpcal.records.batches:JobSummary",
    "wpcal/verify/1": "wpcal.records.batches:Verify",
    "wpcal/diff/1": "wpcal.records.batches:Diff",
    "wpcal/drift/1": "wpcal.records.batches:Drift",
    "wpcal/error-study/1": "wpcal.records.batches:ErrorStudy",
    "wpcal/shop/1": "wpcal.records.batches:Shop",
    "wpcal/shop-rules/1": "wpcal.records.batches:ShopRules",
    "wpcal/error/1": "wpcal.records.batches:Error",
    "wpcal/report/1": "wpcal.records.batches:Report",
}
"""Where the type of each record is, by its name and version."""
