"""`wpcal features`: what can be taught on a part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import JSON_HELP, path_argument

if TYPE_CHECKING:
    from wpcal.taught.features import FeatureChoice, ReferenceFeature


@command()
@path_argument("part_step", metavar="PART.step")
@takes("choice", "wpcal.taught.features:FeatureChoice")
@click.option("--all", "show_all", is_flag=True, help="Leave nothing out: also hidden, vague and indirect features.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: all features.")
def features(*, part_step: Path, choice: FeatureChoice, show_all: bool, as_json: bool, no_cache: bool) -> int:
    """List the reference features of PART.step, with the names that `wpcal calibrate` accepts.

    V: corners. C: circular rims (centre). H: holes (centre of the entry rim). S: sphere centres. M: edge midpoints.
    B: bosses, pins and the outsides of pipes. L: slots. X: corners that a round replaced. E: ends of edges that are not
    corners. P: datum planes. A: cylinder axes. The easiest to touch come first: sharp, round, hidden, vague, indirect.
    The last three are listed with --all or --kind, and always in --json.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.taught.features import choose_features

    judged, issues = run_on_part(
        "cad.workpiece.features:list_features", part_step, {}, what=f"reading {part_step}", use_cache=not no_cache
    )
    chosen = choose_features([item.feature for item in judged], choice)
    ease = {item.feature.name: item.ease.word for item in judged}
    if as_json:
        from wpcal.taught.features import features_record

        print_json(features_record(chosen, ease, issues))
    else:
        from cad.cli.tables import features_table
        from wpcal.cli.console import plain_console, show_notes

        shown = chosen if show_all or choice.kinds else _easy(chosen, ease)
        console = plain_console()
        console.print(features_table(shown, part_step.name, ease))
        if len(shown) < len(chosen):
            console.print(f"{len(chosen) - len(shown)} more are hard to touch; --all lists them")
        show_notes(issues, console)
    return 0


def _easy(chosen: Sequence[ReferenceFeature], ease: Mapping[str, str]) -> Sequence[ReferenceFeature]:
    """Return the features that can be touched well; all if there are none."""
    from wpcal.taught.features import Ease

    easy = {Ease.SHARP.word, Ease.ROUND.word}
    return [feature for feature in chosen if ease[feature.name] in easy] or chosen
