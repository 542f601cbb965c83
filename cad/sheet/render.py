"""Write the drawing of a sheet as DXF, SVG, PDF or PNG. The same sheet gives the same bytes."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from cad.draw.dxf import dxf_text, require_sound
from cad.sheet.paper import Paper

DPI = 200  #: Resolution of the PNG: 0.127 mm per pixel, a third of a pen's width.
MM_PER_INCH = 25.4
POINTS_PER_INCH = 72.0  #: Matplotlib takes pen widths in points, the SVG backend in mm.


def render(documents: Sequence[Any], paper: Paper, suffix: str) -> bytes:
    """Return the bytes of the file; only a PDF has more than one page.

    Raises `KernelError` when a drawing does not pass the library's audit.
    """
    for document in documents:
        require_sound(document)
    if suffix == ".dxf":
        return dxf_text(documents[0]).encode("utf-8")
    return _svg(documents[0], paper) if suffix == ".svg" else _figures(documents, paper, suffix[1:])


def _configuration(pen_scale: float) -> Any:
    from ezdxf.addons.drawing.config import BackgroundPolicy, ColorPolicy, Configuration, LineweightPolicy

    return Configuration(
        background_policy=BackgroundPolicy.WHITE,
        color_policy=ColorPolicy.COLOR,
        lineweight_policy=LineweightPolicy.ABSOLUTE,
        lineweight_scaling=pen_scale,
        min_lineweight=0.0,
    )


def _drawn(document: Any, backend: Any, *, pen_scale: float = 1.0) -> None:
    from ezdxf.addons.drawing import Frontend, RenderContext

    Frontend(RenderContext(document), backend, _configuration(pen_scale)).draw_layout(document.modelspace())


def _svg(document: Any, paper: Paper) -> bytes:
    from ezdxf.addons.drawing import layout
    from ezdxf.addons.drawing.svg import SVGBackend
    from ezdxf.math import BoundingBox2d

    backend = SVGBackend()
    _drawn(document, backend)
    page = layout.Page(paper.width, paper.height, layout.Units.mm, layout.Margins.all(0))
    whole = BoundingBox2d([(0, 0), (paper.width, paper.height)])
    settings = layout.Settings(scale=1.0, fit_page=False)
    text: str = backend.get_string(page, settings=settings, render_box=whole)
    return text.encode("utf-8")


def _figures(documents: Sequence[Any], paper: Paper, kind: str) -> bytes:
    from matplotlib import style
    from matplotlib.backends.backend_pdf import PdfPages

    data = io.BytesIO()
    with style.context("default"):  # not that of a matplotlibrc in the current folder, which could even start TeX
        if kind == "pdf":
            with PdfPages(data, metadata={"CreationDate": None}) as pages:
                for document in documents:
                    pages.savefig(_figure(document, paper), dpi=DPI)
        else:
            _figure(documents[0], paper).savefig(data, format=kind, dpi=DPI, metadata={"Software": None})
    return data.getvalue()


def _figure(document: Any, paper: Paper) -> Any:
    from ezdxf.addons.drawing.matplotlib import MatplotlibBackend
    from matplotlib.figure import Figure

    figure = Figure(figsize=(paper.width / MM_PER_INCH, paper.height / MM_PER_INCH), dpi=DPI)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _drawn(document, MatplotlibBackend(axes, adjust_figure=False), pen_scale=POINTS_PER_INCH / MM_PER_INCH)
    axes.set_xlim(0.0, paper.width)
    axes.set_ylim(0.0, paper.height)
    return figure
