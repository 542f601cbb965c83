"""Examples of records, for their schemas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

EXAMPLES: Mapping[str, list[Any]] = {
    "wpcal/cell/1": [
        {
            "schema": "wpcal/cell/1",
            "name": "a small cell",
            "source": "made up",
            "safety_distance_mm": 20,
            "torch_robot": {
                "arm": "mh6",
                "T_world_base": {"xyz_mm": [0, 0, 0], "rpy_deg": [0, 0, 0]},
                "T_flange_tool": {"xyz_mm": [0, 0, 300], "rpy_deg": [0, 0, 0]},
                "links": [
                    {
                        "name": "pedestal",
                        "link": 0,
                        "capsules": [{"p_mm": [0, 0, 100], "q_mm": [0, 0, 220], "radius_mm": 150}],
                    }
                ],
                "torch": [
                    {
                        "name": "nozzle",
                        "to_part_mm": 3,
                        "capsules": [{"p_mm": [0, 0, -26], "q_mm": [0, 0, -85], "radius_mm": 11}],
                    }
                ],
            },
            "holder_robot": {
                "arm": "mh6",
                "T_world_base": {"xyz_mm": [1500, 0, 0], "rpy_deg": [0, 0, 180]},
                "T_flange_part": None,
                "links": [],
                "part": [],
            },
            "bench": [],
        },
        {
            "schema": "wpcal/cell/1",
            "name": "one robot",
            "source": "made up",
            "safety_distance_mm": 10,
            "torch_robot": {
                "arm": "mh6",
                "T_world_base": {"xyz_mm": [0, 0, 0], "rpy_deg": [0, 0, 0]},
                "T_flange_tool": {"xyz_mm": [0, 0, 300], "rpy_deg": [0, 0, 0]},
                "home_deg": [0, 0, 0, 0, -90, 0],
                "links": [],
                "torch": [],
            },
            "T_world_part": {"xyz_mm": [900, 0, 300], "rpy_deg": [0, 0, 0]},
        },
    ],
    "wpcal/cell-check/1": [
        {
            "schema": "wpcal/cell-check/1",
            "cell": "a small cell",
            "issues": [
                {
                    "code": "no-bodies",
                    "message": "the torch has no bodies: no collision of the torch can be found; list bodies in "
                    "torch_robot.torch",
                    "ids": ["torch"],
                }
            ],
        }
    ],
    "wpcal/pareto/1": [
        {
            "schema": "wpcal/pareto/1",
            "cell": "a small cell",
            "seam": "W1",
            "units": {"length": "mm", "angle": "deg"},
            "speed_mm_s": 6.0,
            "safety_distance_mm": 20,
            "wishes": {"slope_deg": 10.0, "rotation_deg": 0.0},
            "objectives": ["position_deg", "torch_deg", "motion_deg_per_mm"],
            "failed": "no feasible plan: clearance keeps the robots from the start of the seam to its end: robot 1 "
            "nozzle and robot 2 branch pipe: at best 2.0 mm at s = 41.0 mm, 3 mm asked",
            "obstacle": {
                "constraint": "clearance",
                "says": "robot 1 nozzle and robot 2 branch pipe: at best 2.0 mm at s = 41.0 mm, 3 mm asked",
                "advice": "a to_part_mm of 1.9 mm would do at this place",
                "s_mm": 41.0,
                "between": ["robot 1 nozzle", "robot 2 branch pipe"],
                "robot": None,
                "joint": None,
                "best": 2.0,
                "asked": 3.0,
                "unit": "mm",
            },
            "issues": [],
            "plans": [],
        }
    ],
    "wpcal/program/1": [
        {
            "schema": "wpcal/program/1",
            "about": ["written by wpcal"],
            "frame": "base",
            "units": {"length": "mm", "angle": "deg", "speed": "mm/s"},
            "wire_axis": "+z",
            "z_sense": "inward",
            "T_base_part": [[1.0, 0.0, 0.0, 100.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
            "torch": {"work_angle_deg": 0.0, "travel_angle_deg": 0.0, "standoff_mm": 0.0},
            "motion": {"speed_mm_s": 8.0, "air_speed_mm_s": 100.0},
            "seams": [
                {
                    "name": "W1",
                    "joint": "tee",
                    "weld": "fillet",
                    "closed": False,
                    "length_mm": 10.0,
                    "poses": [
                        {
                            "role": "approach",
                            "p_mm": [100.0, 0.0, 50.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
                            "q_xyzw": [1.0, 0.0, 0.0, 0.0],
                            "u95_mm": None,
                        },
                        {
                            "role": "weld",
                            "p_mm": [100.0, 0.0, 0.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
                            "q_xyzw": [1.0, 0.0, 0.0, 0.0],
                            "u95_mm": 0.2,
                        },
                        {
                            "role": "weld",
                            "p_mm": [110.0, 0.0, 0.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
                            "q_xyzw": [1.0, 0.0, 0.0, 0.0],
                            "u95_mm": 0.2,
                        },
                        {
                            "role": "retract",
                            "p_mm": [110.0, 0.0, 50.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
                            "q_xyzw": [1.0, 0.0, 0.0, 0.0],
                            "u95_mm": None,
                        },
                    ],
                }
            ],
            "safe_point": None,
        }
    ],
    "wpcal/seams/1": [
        {
            "schema": "wpcal/seams/1",
            "frame": "base",
            "units": {"length": "mm", "angle": "deg"},
            "z_sense": "outward",
            "robot_space": "nominal",
            "T_base_part": [[1.0, 0.0, 0.0, 100.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
            "seams": [
                {
                    "name": "left fillet",
                    "joint": "tee",
                    "weld": "fillet",
                    "solids": ["base plate", "web"],
                    "closed": False,
                    "length_mm": 10.0,
                    "accepted": True,
                    "reachable": True,
                    "reasons": ["contact of two solids", "9 of 9 frames are free for a torch that does not lean"],
                    "gap_mm": {"min": 0.0, "mean": 0.0, "max": 0.0},
                    "confidence": 0.95,
                    "source": "contact of two solids",
                    "against": [],
                    "candidate": {
                        "name": "W1",
                        "start_part_mm": [0.0, 0.0, 0.0],
                        "middle_part_mm": [5.0, 0.0, 0.0],
                        "length_mm": 10.0,
                    },
                    "edit": {"name": "left fillet"},
                    "frames": [
                        {
                            "s_mm": 0.0,
                            "p_mm": [100.0, 0.0, 0.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                            "q_xyzw": [0.0, 0.0, 0.0, 1.0],
                            "angle_deg": 90.0,
                            "u95_mm": 0.2,
                        },
                        {
                            "s_mm": 10.0,
                            "p_mm": [110.0, 0.0, 0.0],
                            "R": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                            "q_xyzw": [0.0, 0.0, 0.0, 1.0],
                            "angle_deg": 90.0,
                            "u95_mm": 0.2,
                        },
                    ],
                    "findings": [],
                }
            ],
            "judging": {"weld": [], "not": ["vane*"], "level": "usual", "least_confidence": 0.5},
            "members": [
                {
                    "solid": "web",
                    "taken_as": "a member",
                    "factor": 1.0,
                    "why": ["nothing speaks against welding it"],
                    "said": None,
                }
            ],
        }
    ],
    "wpcal/torch/1": [
        {
            "schema": "wpcal/torch/1",
            "title": "Robot torch, neck of 45 degrees",
            "source": "Typical of this class of torch, rounded and set by hand: gas nozzles of 20 to 26 mm, necks of "
            "20 to 24 mm, bodies of 36 to 50 mm. It is not the data sheet of a product: measure your torch.",
            "rank": 3,
            "wire": {"usual_mm": 18, "most_mm": 25},
            "nozzle": {"diameter_mm": 24, "mouth_diameter_mm": 19, "taper_mm": 20},
            "neck": {
                "angle_deg": 45,
                "from_mouth_mm": 70,
                "bend_radius_mm": 60,
                "diameter_mm": 22,
                "body_from_mm": 165,
                "body_diameter_mm": 44,
            },
            "length_mm": 320,
        }
    ],
    "wpcal/welds/1": [
        {
            "schema": "wpcal/welds/1",
            "welds": [{"name": "W1", "values": {"throat_mm": 4, "stitch": {"length_mm": 50, "pitch_mm": 100}}}],
        }
    ],
}
"""By the name of the record."""
