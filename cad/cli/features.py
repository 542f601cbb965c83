"""`wpcal features`: what can be taught on a part."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.option("--kind", type=click.Choice(["V", "C", "H", "S", "M"]), multiple=True, help="Only these kinds.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")
def features(*, part_step: Path, kind: tuple[str, ...], as_json: bool) -> int:
    """List the reference features of PART.step, with the names that `wpcal calibrate` accepts.

    V: corners. C: circular rims (centre). H: holes (centre of the entry rim). S: sphere centres. M: edge midpoints.
    """
    from cad.child import run_in_child
    from cad.cli.progress import shown_progress

    with shown_progress() as progress:
        found = run_in_child(
            "cad.convert:list_features", {"step": part_step}, what=f"reading {part_step}", progress=progress
        )
    chosen = [feature for feature in found if not kind or feature.kind.value in kind]
    if as_json:
        from wpcal.core.records import to_json
        from wpcal.features import features_record

        click.echo(to_json(features_record(chosen)), nl=False)
    else:
        from cad.cli.tables import features_table
        from wpcal.cli.console import plain_console

        plain_console().print(features_table(chosen, part_step.name))
    return 0
