"""Draw the README's picture: a sample part with its seams and frames. Usage: python docs/make_picture.py"""

from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np

from cad.kernel.to_brep import to_brep
from cad.samples.parts import SAMPLES
from wpcal.brep.curves import edge_polylines
from wpcal.seam import detect_seams
from wpcal.taught.features import feature_named, find_features

mpl.use("Agg")
import matplotlib.pyplot as plt

TRIAD_MM = 9.0


def draw(axes, name: str) -> None:
    sample = SAMPLES[name]
    graph = to_brep((member, shape) for member, shape, _ in sample.build())
    start, _, points = edge_polylines(graph)
    for a, b in pairwise(start):
        axes.plot(*points[a:b].T, color="0.55", linewidth=0.8)
    for seam in detect_seams(graph):
        p, R = seam.frames.p, seam.frames.R
        axes.plot(*p.T, color="#c0392b" if seam.accepted else "0.8", linewidth=2.5)
        if seam.accepted:
            for row in range(0, len(p), 3):
                for axis, colour in enumerate(("#e67e22", "#27ae60", "#2980b9")):
                    tip = np.stack([p[row], p[row] + TRIAD_MM * R[row, :, axis]])
                    axes.plot(*tip.T, color=colour, linewidth=1.0)
    features = find_features(graph)
    for taught in sample.taught[:4]:
        p = feature_named(features, taught).p_mm
        axes.scatter(*p, color="black", s=14)
        axes.text(*(p + 4), taught, fontsize=8)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.view_init(elev=28, azim=-58)


figure = plt.figure(figsize=(10, 4.4), dpi=110)
for column, name in enumerate(("tee", "saddle"), 1):
    draw(figure.add_subplot(1, 2, column, projection="3d"), name)
figure.subplots_adjust(0, 0, 1, 1, 0, 0)
figure.savefig(Path(__file__).parent / "images" / "seams.png", metadata={"Software": None})
