"""A `BrepGraph` as a file: NumPy arrays in an ``.npz``, so that rules about a part run without a CAD kernel.

The same graph gives the same bytes: the entries are not compressed and carry a fixed date. Splines of different sizes
are stored one after the other, with their counts.
"""

import io
import json
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import MISSING, asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.brep.solid_facts import SolidFacts
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import FormatError
from wpcal.core.input_file import read_bytes

FORMAT = "wpcal graph 1"  #: Name and version, stored as the array ``format``.
FIXED_DATE = (1980, 1, 1, 0, 0, 0)  #: The earliest date that a zip archive can hold.
COLUMNS = tuple(f.name for f in fields(BrepGraph) if f.default is MISSING and f.name != "solid_names")
"""The fields of a graph that are arrays; each is stored under its own name. Balls in grooves are not stored."""


def graph_bytes(graph: BrepGraph) -> bytes:
    """Return the content of a graph's file; `read_graph` reads it."""
    arrays = {
        "format": np.array(FORMAT),
        "solid_names": np.array(graph.solid_names, dtype=np.str_),
        **{name: getattr(graph, name) for name in COLUMNS},
        **_curve_arrays(graph.nurbs_curves),
        **_surface_arrays(graph.nurbs_surfaces),
    }
    if graph.solid_facts:  # as one text: older files do not have it
        arrays["solid_facts"] = np.array(json.dumps([asdict(one) for one in graph.solid_facts]))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, np.asarray(array, order="C"), version=(1, 0), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy", FIXED_DATE), content.getvalue())
    return file.getvalue()


def read_graph(path: Path) -> BrepGraph:
    """Read the graph of a part from a file that holds `graph_bytes`.

    Raises `InputError` if the file cannot be opened.
    Raises `FormatError` if it is not a graph file, is of another version, or is incomplete.
    """
    content = read_bytes(path)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (ValueError, EOFError, OSError, AttributeError, RuntimeError, zipfile.BadZipFile, zlib.error):
        raise FormatError("is not a saved graph: expected an .npz archive of plain arrays", path=str(path)) from None
    found = str(arrays.get("format", "no format"))
    if found != FORMAT:
        raise FormatError(f"expected the format {FORMAT!r}, found {found!r}", path=str(path))
    try:
        return BrepGraph(
            solid_names=tuple(arrays["solid_names"].tolist()),
            **{name: arrays[name] for name in COLUMNS},
            nurbs_curves=_curves(arrays),
            nurbs_surfaces=_surfaces(arrays),
            solid_facts=_facts(arrays, path=str(path)),
        )
    except KeyError as error:
        raise FormatError(f"the array {error} is missing from the graph", path=str(path)) from None


def _facts(arrays: dict[str, Any], *, path: str) -> tuple[SolidFacts, ...]:
    if "solid_facts" not in arrays:
        return ()
    try:
        return tuple(_solid_facts(one) for one in json.loads(str(arrays["solid_facts"])))
    except (TypeError, ValueError, AttributeError, KeyError):
        raise FormatError("the array 'solid_facts' does not describe solids", path=path) from None


def _solid_facts(one: dict[str, Any]) -> SolidFacts:
    texts = {name: tuple(str(text) for text in one[name]) for name in ("path", "products", "materials")}
    color, density = one["color_rgb"], one["density_kg_m3"]
    red, green, blue = (0.0, 0.0, 0.0) if color is None else (float(v) for v in color)
    return SolidFacts(
        **texts,
        color_rgb=None if color is None else (red, green, blue),
        density_kg_m3=None if density is None else float(density),
    )


def _curve_arrays(curves: Sequence[NurbsCurve]) -> dict[str, Any]:
    return {
        "curve_degree": np.array([curve.degree for curve in curves], dtype=np.int64),
        **_stacked("curve_knots", [curve.knots for curve in curves]),
        **_stacked("curve_poles", [curve.poles.ravel() for curve in curves]),
        **_stacked("curve_weights", [curve.weights for curve in curves]),
    }


def _curves(arrays: dict[str, Any]) -> tuple[NurbsCurve, ...]:
    columns = [_split(arrays, f"curve_{name}") for name in ("knots", "poles", "weights")]
    return tuple(
        NurbsCurve(degree, knots, poles.reshape(-1, 3), weights)
        for degree, knots, poles, weights in zip(arrays["curve_degree"].tolist(), *columns, strict=True)
    )


def _surface_arrays(surfaces: Sequence[NurbsSurface]) -> dict[str, Any]:
    return {
        "surface_degrees": np.array([surface.degrees for surface in surfaces], dtype=np.int64).reshape(-1, 2),
        "surface_bounds": np.array([surface.bounds for surface in surfaces], dtype=np.float64).reshape(-1, 4),
        "surface_shape": np.array([surface.weights.shape for surface in surfaces], dtype=np.int64).reshape(-1, 2),
        **_stacked("surface_knots_u", [surface.knots_u for surface in surfaces]),
        **_stacked("surface_knots_v", [surface.knots_v for surface in surfaces]),
        **_stacked("surface_poles", [surface.poles.ravel() for surface in surfaces]),
        **_stacked("surface_weights", [surface.weights.ravel() for surface in surfaces]),
    }


def _surfaces(arrays: dict[str, Any]) -> tuple[NurbsSurface, ...]:
    columns = [_split(arrays, f"surface_{name}") for name in ("knots_u", "knots_v", "poles", "weights")]
    heads = zip(*(arrays[f"surface_{name}"].tolist() for name in ("degrees", "bounds", "shape")), strict=True)
    return tuple(
        NurbsSurface(tuple(degrees), knots_u, knots_v, poles.reshape(*shape, 3), weights.reshape(shape), tuple(bounds))
        for (degrees, bounds, shape), knots_u, knots_v, poles, weights in zip(heads, *columns, strict=True)
    )


def _stacked(name: str, parts: Sequence[FloatArray]) -> dict[str, FloatArray | IntArray]:
    """Return flat arrays as one, with how long each of them is."""
    count = np.array([len(part) for part in parts], dtype=np.int64)
    return {name: np.concatenate([np.zeros(0), *parts]), f"{name}_count": count}


def _split(arrays: dict[str, Any], name: str) -> list[FloatArray]:
    return np.split(arrays[name], np.cumsum(arrays[f"{name}_count"]))[:-1]
