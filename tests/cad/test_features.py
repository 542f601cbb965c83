"""Reference features of files; `unit/features/test_features.py` has the rules, on saved graphs."""

from collections import Counter
from pathlib import Path

import numpy as np

from cad.workpiece.features import list_features
from cad.workpiece.workpiece import open_workpiece
from wpcal.taught.features import Ease, FeatureKind, HoleForm, feature_named

ROUND_OFF_MM = 1e-9  #: Coordinates of some hundred mm through a few products in double precision.
TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


def test_nist_ftc_06_has_twelve_holes_and_eight_bosses(shared_step: Path) -> None:
    features = open_workpiece(shared_step / "nist_ftc_06_asme1_ap242-e2.stp").features
    kinds = Counter(feature.kind for feature in features)
    assert kinds[FeatureKind.BOSS] == 8
    holes = [feature for feature in features if feature.kind is FeatureKind.HOLE]
    assert Counter((hole.form, hole.is_through) for hole in holes) == {
        (HoleForm.COUNTERBORE, True): 10,
        (HoleForm.PLAIN, False): 2,
    }
    diameters = [step.diameter_mm / 25.4 for step in feature_named(features, "H1").steps]
    np.testing.assert_allclose(diameters, [0.625, 0.415], rtol=0, atol=ROUND_OFF_MM)


def test_the_easiest_come_first() -> None:
    judged, _, _ = list_features(TEE)
    assert [item.ease for item in judged] == sorted(item.ease for item in judged)
    assert {item.feature.kind for item in judged if item.ease is Ease.SHARP} == {FeatureKind.VERTEX, FeatureKind.HOLE}
