"""Bodies that lie on each other: which faces touch, and what keeping them so gives."""

from pathlib import Path

import numpy as np
import pytest

from cad.workpiece.bodies import BodiesOptions, PartBodies, find_bodies
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.weldments import contacts_of_uprights, fit_bodies, uprights
from wpcal.calibrate.observe.bodies import KeptContacts
from wpcal.calibrate.observe.contacts import find_kept_contacts
from wpcal.calibrate.observe.motions import Motions
from wpcal.core.errors import InputError

UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights" / "uprights.step"


@pytest.fixture(scope="module")
def part() -> tuple[Workpiece, PartBodies]:
    workpiece = open_workpiece(UPRIGHTS)
    return workpiece, find_bodies(workpiece.trimmed, BodiesOptions())


def test_each_upright_lies_on_the_base_with_four_corners(part: tuple[Workpiece, PartBodies]) -> None:
    workpiece, bodies = part
    found = find_kept_contacts(workpiece.trimmed, bodies.face_body, gap_mm=0.5, sigma_mm=0.3)
    names = bodies.bodies.names
    pairs = [{names[a], names[b]} for a, b in zip(found.first, found.second, strict=True)]
    for number in range(1, 5):
        own = found.p_part[[pair == {"base", f"U{number}"} for pair in pairs]]
        assert len(own) == 4
        np.testing.assert_allclose(own[:, 2], 0.0, atol=1e-9, rtol=0)
        spread = np.sort(np.ptp(own, axis=0)[:2])
        assert spread[0] == pytest.approx(8.0, abs=1e-9)
        assert spread[1] in (200.0, 480.0)
    assert len(found) == 16
    np.testing.assert_allclose(np.abs(found.normal_part[:, 2]), 1.0, atol=1e-12, rtol=0)
    np.testing.assert_allclose(found.sigma_mm, 0.3 * np.sqrt(4.0 / 3.0), rtol=0, atol=1e-12)


def test_faces_of_one_body_do_not_touch_each_other(part: tuple[Workpiece, PartBodies]) -> None:
    workpiece, bodies = part
    assert not len(find_kept_contacts(workpiece.trimmed, np.zeros_like(bodies.face_body), gap_mm=0.5, sigma_mm=0.3))


def test_a_kept_contact_gives_height_and_tilt_that_no_touch_sees() -> None:
    """With sigma → 0 the plates stay on the base to it; their tilt is then the base's. Without, it is the tolerance."""
    rng = np.random.default_rng(4)
    part = uprights(2)
    true = part.drawn(rng)
    contacts = contacts_of_uprights(1e-4)
    touches = part.touched(true, 0.1, rng)
    kept = fit_bodies(touches, part.body, part.bodies, true.T_base_part, sigma_mm=0.1, contacts=contacts)
    free = fit_bodies(touches, part.body, part.bodies, true.T_base_part, sigma_mm=0.1)
    assert np.abs(gaps(kept.motions, contacts)).max() < 1e-3
    assert np.abs(gaps(free.motions, contacts)).max() > 0.1
    for b in range(1, 5):
        assert kept.covariance[11 + 6 * b, 11 + 6 * b] < 0.5 * free.covariance[11 + 6 * b, 11 + 6 * b]
    assert np.trace(kept.covariance) < np.trace(free.covariance)


def test_a_loose_contact_changes_nothing() -> None:
    rng = np.random.default_rng(5)
    part = uprights(3)
    true = part.drawn(rng)
    touches = part.touched(true, 0.1, rng)
    loose = contacts_of_uprights(1e6)
    kept = fit_bodies(touches, part.body, part.bodies, true.T_base_part, sigma_mm=0.1, contacts=loose)
    free = fit_bodies(touches, part.body, part.bodies, true.T_base_part, sigma_mm=0.1)
    np.testing.assert_allclose(kept.motions.v_mm, free.motions.v_mm, rtol=0, atol=1e-6)


def gaps(motions: Motions, contacts: KeptContacts) -> np.ndarray:
    apart = motions.apply(contacts.first, contacts.p_part) - motions.apply(contacts.second, contacts.p_part)
    return np.einsum("ki,ki->k", apart, contacts.normal_part)


@pytest.mark.parametrize("sigma_mm", [0.0, -1.0, float("nan"), float("inf")])
def test_a_gap_that_is_not_positive_is_refused(sigma_mm: float) -> None:
    with pytest.raises(InputError, match="must be a positive number"):
        BodiesOptions(keeps_contacts=True, contact_sigma_mm=sigma_mm)
