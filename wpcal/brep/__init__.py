"""The boundary of a part as plain arrays: faces, edges, adjacency, and geometry evaluated many points at once."""

from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind

__all__ = ["BrepGraph", "CurveKind", "SurfaceKind"]
