"""What is found on saved graphs, and what the programs of the docs make controllers do: each field is golden."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from tests.saved_graphs import GRAPHS, saved_graph, saved_seams
from tests.shown_programs import PROGRAMS
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.targets import _Cloud
from wpcal.controllers.audit.programs import Surroundings, executed
from wpcal.controllers.judge.execute import interpreted
from wpcal.controllers.registry import grammar_of_file
from wpcal.core.transform import RigidTransform
from wpcal.seam.explain import explain_seam
from wpcal.seam.member.note import take_members
from wpcal.seam.options import Judging
from wpcal.taught.features import find_features, judge_features

MOVED = {"frame-backwards", "block-shifted", "block-turned"}  #: The laws of moved parts are about these.
LANGUAGES = ("", "rapid", "krl", "fanuc", "inform", "urscript", "val3", "as")
WAITING = {"WPCAL_touch.src"}  #: Waits for a search until the interpreter gives up, which takes 5 s.
PLACE = RigidTransform.from_six_tuple([813.0, -207.0, 419.0, 0.3, -0.2, 1.1], target="base", source="part")


@pytest.mark.parametrize("name", sorted({path.stem for path in GRAPHS.glob("*.npz")} - MOVED))
def test_features_members_and_seams(name: str, golden: Any) -> None:
    graph, seams = saved_graph(name), saved_seams(name)
    notes = take_members(graph, TrimmedFaces.of(graph), Judging()).notes
    told = [explain_seam(graph, seam, notes) for seam in seams]
    features = judge_features(graph, find_features(graph))
    golden({"features": features, "members": notes, "seams": seams, "told": told})


@pytest.mark.parametrize("folder", sorted(path.name for path in PROGRAMS.iterdir()))
def test_points_and_motions(folder: str, golden: Any) -> None:
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted((PROGRAMS / folder).iterdir())}
    known = {name: grammar for name in texts if (grammar := grammar_of_file(Path(name))) is not None}
    read = [grammar.read(texts[name], name) for name, grammar in known.items() if grammar.has_poses(Path(name))]
    together = defaultdict[str, dict[str, str]](dict)  # programs of one language that one controller has
    for name in sorted(set(texts) - WAITING):
        language = "" if (controller := interpreted(name)) is None else controller.name
        assert language in LANGUAGES
        together[language + name[-7:-4] * ("_R" in name)][name] = texts[name]
    golden([read, [executed(own, Surroundings(PLACE)) for own in together.values()]])


def test_samples_of_a_free_form_face(golden: Any) -> None:
    golden(_Cloud.of(TrimmedFaces.of(saved_graph("bead-leaning-pipe")), 1))
