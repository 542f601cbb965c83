"""Choosing among features, and names nearest to an unknown one."""

import numpy as np
import pytest

from wpcal.core.arrays import frozen
from wpcal.core.errors import InputError
from wpcal.taught.features import (
    FeatureChoice,
    FeatureKind,
    ReferenceFeature,
    choose_features,
    feature_named,
    point_named,
)


def feature(name: str, x: float, diameter_mm: float | None, solid: str) -> ReferenceFeature:
    return ReferenceFeature(name, FeatureKind(name[0]), frozen([x, 0, 0]), None, diameter_mm, solid)


PART = (
    feature("V1", 0, None, "plate"),
    feature("V2", 10, None, "web"),
    feature("H1", 5, 8.0, "plate"),
    feature("H2", 7, 20.0, "web left"),
)


def names(chosen: tuple[ReferenceFeature, ...]) -> list[str]:
    return [item.name for item in chosen]


def test_conditions_hold_together() -> None:
    assert names(choose_features(PART, FeatureChoice())) == ["V1", "V2", "H1", "H2"]
    assert names(choose_features(PART, FeatureChoice(kinds=(FeatureKind.HOLE,)))) == ["H1", "H2"]
    assert names(choose_features(PART, FeatureChoice(solid="web*"))) == ["V2", "H2"]
    assert names(choose_features(PART, FeatureChoice(solid="web*", kinds=(FeatureKind.VERTEX,)))) == ["V2"]
    assert names(choose_features(PART, FeatureChoice(min_diameter_mm=8.0))) == ["H1", "H2"]


def test_the_nearest_come_first() -> None:
    assert names(choose_features(PART, FeatureChoice(near=(6.9, 0, 0)))) == ["H2", "H1", "V2", "V1"]


def test_an_unknown_solid_says_which_there_are() -> None:
    with pytest.raises(InputError, match="the part has plate, web, web left"):
        choose_features(PART, FeatureChoice(solid="flange"))
    with pytest.raises(InputError, match="three finite numbers"):
        choose_features(PART, FeatureChoice(near=(np.nan, 0, 0)))


def test_names_are_found_in_any_case() -> None:
    assert feature_named(PART, " h2 ") is PART[3]
    with pytest.raises(InputError, match="near: H"):
        feature_named(PART, "H7")


def test_a_plane_is_no_point() -> None:
    datum = feature("P1", 3, None, "plate")
    with pytest.raises(InputError, match="P1 is a datum plane"):
        point_named((*PART, datum), "p1")
    assert point_named(PART, "h1").tolist() == [5, 0, 0]
