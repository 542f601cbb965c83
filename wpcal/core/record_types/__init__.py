"""The records that wpcal writes, declared once as types; their JSON Schemas are generated from these.

A field says its type, its bounds and, where the name does not, its meaning. `schema_of` makes the JSON Schema (draft
2020-12) of a type, and `wpcal.core.record_check` reads with it. A class is found by the name that its record states.
"""

from __future__ import annotations

from collections.abc import Mapping

RECORDS: Mapping[str, str] = {
    "wpcal/calibration/1": "wpcal.core.record_types.calibration:Calibration",
    "wpcal/seams/1": "wpcal.core.record_types.seams:Seams",
    "wpcal/truth/1": "wpcal.core.record_types.seams:Truth",
    "wpcal/welds/1": "wpcal.core.record_types.welds:Welds",
    "wpcal/weld-rules/1": "wpcal.core.record_types.welds:WeldRules",
    "wpcal/arm/1": "wpcal.core.record_types.robots:Arm",
    "wpcal/torch/1": "wpcal.core.record_types.robots:Torch",
    "wpcal/torches/1": "wpcal.core.record_types.robots:Torches",
    "wpcal/tool/1": "wpcal.core.record_types.robots:Tool",
    "wpcal/cell-errors/1": "wpcal.core.record_types.robots:CellErrors",
    "wpcal/identification/1": "wpcal.core.record_types.robots:Identification",
    "wpcal/pose-plan/1": "wpcal.core.record_types.robots:PosePlan",
    "wpcal/corrected/1": "wpcal.core.record_types.robots:Corrected",
    "wpcal/cell/1": "wpcal.core.record_types.cells:Cell",
    "wpcal/cell-check/1": "wpcal.core.record_types.cells:CellCheck",
    "wpcal/place/1": "wpcal.core.record_types.cells:Place",
    "wpcal/plan/1": "wpcal.core.record_types.plans:Plan",
    "wpcal/pareto/1": "wpcal.core.record_types.plans:Pareto",
    "wpcal/weld-sequence/1": "wpcal.core.record_types.plans:WeldSequence",
    "wpcal/program/1": "wpcal.core.record_types.programs:Program",
    "wpcal/export/1": "wpcal.core.record_types.programs:Export",
    "wpcal/ros-sidecar/1": "wpcal.core.record_types.programs:RosSidecar",
    "wpcal/compas/1": "wpcal.core.record_types.programs:Compas",
    "wpcal/formats/1": "wpcal.core.record_types.programs:Formats",
    "wpcal/touchup/1": "wpcal.core.record_types.programs:TouchUp",
    "wpcal/audit/1": "wpcal.core.record_types.programs:Audit",
    "wpcal/taught/1": "wpcal.core.record_types.points:Taught",
    "wpcal/match/1": "wpcal.core.record_types.points:Match",
    "wpcal/features/1": "wpcal.core.record_types.points:Features",
    "wpcal/bodies/1": "wpcal.core.record_types.points:Bodies",
    "wpcal/pick-draft/1": "wpcal.core.record_types.points:PickDraft",
    "wpcal/sheet/1": "wpcal.core.record_types.points:Sheet",
    "wpcal/advice/1": "wpcal.core.record_types.touching:Advice",
    "wpcal/moved-advice/1": "wpcal.core.record_types.touching:MovedAdvice",
    "wpcal/touches/1": "wpcal.core.record_types.touching:Touches",
    "wpcal/batch/1": "wpcal.core.record_types.batches:Batch",
    "wpcal/job/1": "wpcal.core.record_types.batches:JobRecord",
    "wpcal/job-summary/1": "wpcal.core.record_types.batches:JobSummary",
    "wpcal/verify/1": "wpcal.core.record_types.batches:Verify",
    "wpcal/diff/1": "wpcal.core.record_types.batches:Diff",
    "wpcal/drift/1": "wpcal.core.record_types.batches:Drift",
    "wpcal/error-study/1": "wpcal.core.record_types.batches:ErrorStudy",
    "wpcal/shop/1": "wpcal.core.record_types.batches:Shop",
    "wpcal/shop-rules/1": "wpcal.core.record_types.batches:ShopRules",
    "wpcal/error/1": "wpcal.core.record_types.batches:Error",
    "wpcal/report/1": "wpcal.core.record_types.batches:Report",
}
"""Where the type of each record is, by its name and version."""
