"""What to do now, from the record of a calibration: which row to touch again, which point to add, which σ to state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from wpcal.core.wording import MOST_NAMED, listed

HELP_PAGE = "docs/how-to/fail-what-now.md"  #: The page that explains every verdict sentence.

AGAIN = "Then calibrate again."
SMALL = 10.0
"""A row that is off by less than this many stated teaching errors may be blamed for a stated error too small."""
_list = partial(listed, most=MOST_NAMED)


def next_steps(calibration: Mapping[str, Any]) -> list[str]:
    """Return what a person does next, the most useful step first."""
    judgement = calibration.get("judgement") or {}
    reason = judgement.get("reason")
    if calibration.get("verdict") == "PASS" or reason not in _STEPS:
        return []
    by_reason = _BODY_STEPS if "bodies" in calibration and reason in _BODY_STEPS else _STEPS
    return [*by_reason[reason](calibration, judgement), AGAIN]


def _contradiction(calibration: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    issues = {issue["code"]: issue for issue in reversed(calibration.get("issues", []))}
    suspect = calibration.get("suspect") or {}
    if "swapped-names" in issues:
        names = " and ".join(issues["swapped-names"]["ids"][:2])
        return [f"Exchange the names {names} in the table if they were mixed up. If not, touch both again."]
    if "mirrored" in issues:
        return [
            "Check the sign of each axis, and that the taught frame is right-handed.",
            "Check that the STEP file is of this hand of the part, not of its mirror image.",
        ]
    if "tool_offset" in calibration:
        return [
            "Calibrate the tool centre point on the controller, or find it with wpcal tcp.",
            "Touch all points again with the corrected tool.",
        ]
    if suspect.get("exchanges"):
        return [_exchanged(one) for one in suspect["exchanges"]]
    if suspect.get("names"):
        return _elsewhere(suspect) if suspect.get("body") else _named(calibration, suspect)
    return _unnamed(calibration, suspect, judgement)


def _exchanged(one: Mapping[str, Any]) -> str:
    row, feature = one["name"], one["feature"]
    return f"If {feature} was touched, write {feature} as the feature of row {row}. If not, touch {row} again."


def _named(calibration: Mapping[str, Any], suspect: Mapping[str, Any]) -> list[str]:
    listed = _list(suspect["names"])
    steps = [f"Touch {listed} again, and check that the row names the feature that you touch."]
    without = (calibration.get("distrusted") or {}).get("without")
    if without is not None:
        verb = "its" if len(suspect["names"]) == 1 else "their"
        steps.append(
            f"If you cannot touch {listed} again, write no into {verb} column use: the seams are then predicted within "
            f"{without['seam_error_95_mm']:.2g} mm."
        )
    stated = calibration.get("teaching_error", {})
    near = max(suspect.get("off_mm", ()), default=0.0) <= SMALL * stated.get("used_sigma_mm", 0.0)
    if near and stated.get("provenance") == "stated":  # a stated error that is too small blames good rows
        steps += _state_sigma(calibration)
    return steps


def _elsewhere(suspect: Mapping[str, Any]) -> list[str]:
    body = suspect["body"]
    return [
        f"Measure where {body} stands against the model. If it was tacked there, calibrate with --bodies.",
        f"If {body} is drawn there in another revision, calibrate with the model of that revision.",
        f"If it stands as in the model, touch {_list(suspect['names'])} again: do the rows name what you touched?",
    ]


def _unnamed(calibration: Mapping[str, Any], suspect: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    rivals = [name for rival in suspect.get("rivals", []) for name in rival["names"]]
    if rivals:
        return [f"Touch {_list(dict.fromkeys(rivals))} again, in this order.", _add_point(judgement)]
    return ["Touch all points again: two or more are wrong.", *_state_sigma(calibration), _add_point(judgement)]


def _stated_error(calibration: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    return [
        "Touch the points with the largest residuals again: " + _list(_worst(calibration)) + ".",
        *_state_sigma(calibration),
        "Measure one distance on the part: if it is not that of the model, the model is wrong there.",
    ]


def _state_sigma(calibration: Mapping[str, Any]) -> list[str]:
    sigma = _seen_sigma(calibration)
    if sigma is None:
        return []
    return [
        "If your touches are as rough as that, state the teaching error that these residuals show "
        f"(--sigma-mm {sigma:.2g})."
    ]


def _too_large(calibration: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    used = calibration.get("teaching_error", {})
    steps = [_add_point(judgement)]
    sigma, error = used.get("used_sigma_mm"), judgement["error_95_mm"]
    bias = math.sqrt(2.0) * (used.get("tcp_bias_mm") or 0.0)
    room, now = calibration["tolerance_mm"] - bias, error - bias
    if bias and room <= 0:
        return ["Calibrate the tool centre point: its stated error alone exceeds the tolerance.", *steps]
    if sigma and now > 0:
        needed = sigma * room / now
        if used.get("provenance") == "stated":
            steps.append(f"Or touch more carefully: {needed:.2g} mm per axis would be enough for these points.")
        else:
            steps.append(f"If you know your teaching error, state it (--sigma-mm): {needed:.2g} mm per axis is enough.")
    return steps


def _add_point(judgement: Mapping[str, Any]) -> str:
    found = judgement.get("next_points") or [one for one in [judgement.get("next_point")] if one]
    if found:
        helps = "it helps" if len(found) == 1 else "they help"
        return f"Touch {_list(found)} as well: of the features not yet touched, {helps} the seams most."
    return "Add a point far from the others, best beyond the ends of the seams (wpcal advise proposes one)."


def _unchecked(_: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    return [_add_point(judgement), "Or touch one more point as a check point (use: check)."]


def _check(calibration: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    checks = [point for point in calibration["points"] if point["use"] == "check"]
    worst = max(checks, key=lambda point: point["distance_mm"], default=None)
    name = "the check point" if worst is None else f"check point {worst['name']}"
    return [
        f"Touch {name} again.",
        "If it is still off, the part differs from its model there, or a fitted point is wrong: add a point near it.",
    ]


def _rival(calibration: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    if "touches" not in calibration:
        return [
            "Check the names of the points: some may be exchanged, or the part is mirrored.",
            "Touch one more point that is not symmetric to the others.",
        ]
    return ["Touch one more face, of another direction.", "Or give the rough place of the part (--nominal)."]


def _scale(calibration: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    return [
        "Measure a known length of the part with the robot and with a ruler.",
        "If the part is warm, let it cool, or state its temperature (--part-temperature). If the lengths differ, have "
        "the robot calibrated (wpcal identify), or take the size that the touches show (--scale free).",
    ]


def _silent(_: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    return [
        "Look at the part: does it stand as in the model, not turned or mirrored?",
        "Run the touch program again. If the same search finds nothing, check the wire and the touch signal there.",
    ]


def _worst(calibration: Mapping[str, Any]) -> list[str]:
    points = sorted(calibration["points"], key=lambda point: -point["distance_mm"])
    return [point["name"] for point in points[:2]]


def _seen_sigma(calibration: Mapping[str, Any]) -> float | None:
    """Teaching error per axis that the residuals of points show, mm; None for touches, which see fewer numbers."""
    fitted = [point for point in calibration["points"] if point["use"] == "yes"]
    freedom = 3 * len(fitted) - 6
    if "touches" in calibration or freedom < 1:
        return None
    return math.sqrt(sum(point["distance_mm"] ** 2 for point in fitted) / freedom)


def _moved_contradiction(calibration: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    wrong = _list(calibration["bodies"]["wrong_touches"])
    broken = calibration["bodies"].get("contacts", {}).get("broken", ())
    pairs = _list([" and ".join(each["bodies"]) for each in broken])
    steps = [f"Calibrate without --contacts: {pairs} do not stay on each other."] if pairs else []
    if wrong:
        steps.append(f"Touch {wrong} again, and check that the row names the feature or the place that you touch.")
    return [*steps, *_far(calibration)]


def _moved_residuals(calibration: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    """With bodies that moved: a body may be farther away than its tolerance explains."""
    return _far(calibration) or _stated_error(calibration, judgement)


def _far(calibration: Mapping[str, Any]) -> list[str]:
    far = calibration["bodies"].get("far_bodies")
    if not far:
        return []
    return [f"If new touches on {_list(far)} agree, state a larger tolerance (--tack-mm, --tack-mrad)."]


def _moved_too_large(calibration: Mapping[str, Any], judgement: Mapping[str, Any]) -> list[str]:
    """With bodies that moved: touch the bodies of the worst seam, or touch more carefully."""
    bodies = calibration["bodies"]
    seam = next((row for row in bodies["seams"] if row["seam"] == judgement.get("seam")), None)
    if seam is None:
        return [_add_point(judgement)]
    steps = [_add_point(judgement)] if judgement.get("next_point") else []
    touches = {row["name"]: row["touches"] for row in bodies["bodies"]}
    if seam["never_touched"]:
        steps.append(f"Touch {_list(seam['never_touched'])}: no touch lies there yet.")
    elif seam["u95_unseen_mm"] > seam["u95_placing_mm"] and seam["u95_across_mm"] < seam["u95_mm"] / 2.0:
        steps.append(
            f"Touch {_list(seam['bodies'])} on faces across {seam['seam']}: its ends may be off along it, "
            f"where no touch sees them; across it, it is within {seam['u95_across_mm']:.2g} mm."
        )
    elif seam["u95_unseen_mm"] > seam["u95_placing_mm"]:
        fewest = min(seam["bodies"], key=lambda name: touches.get(name, 0))
        steps.append(
            f"Touch {fewest} on more of its faces: {seam['u95_unseen_mm']:.2g} mm of the error of {seam['seam']} are "
            "from motions of bodies that no touch saw."
        )
    else:
        steps.append(
            f"Touch {_list(seam['bodies'])} more often or more carefully: {seam['u95_placing_mm']:.2g} mm of the error "
            f"of {seam['seam']} are from the errors of the touches."
        )
    if bodies["tolerances"] == "assumed":
        steps.append("If you know how far your tacks let the bodies move, state it (--tack-mm, --tack-mrad).")
    return steps


_STEPS = {
    "contradiction": _contradiction,
    "stated-error": _stated_error,
    "large-residuals": _stated_error,
    "beyond": _too_large,
    "scale": _scale,
    "error": _too_large,
    "unchecked": _unchecked,
    "check": _check,
    "check-contradicts": _check,
    "rival": _rival,
    "silent-search": _silent,
}
_BODY_STEPS = {
    "contradiction": _moved_contradiction,
    "error": _moved_too_large,
    "beyond": _moved_too_large,
    "stated-error": _moved_residuals,
    "large-residuals": _moved_residuals,
}
