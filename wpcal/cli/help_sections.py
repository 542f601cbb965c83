"""The help of a command with many options: the usual ones under headings on one screen, all with ``--help-all``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import click

MOST_ON_A_SCREEN = 22  #: A command with this many options or fewer shows them all.
SECTIONS = {
    "What you have": """
        nominal bodies touches seams cell robot torch tool uframe part only welds template have exclude
    """,
    "How good it must be": """
        tolerance_mm sigma_mm robot_mm criterion accept_unsure count position work_angle_deg speed_mm_s arc pattern
    """,
    "What to write": "out format report html png program_name check details force json no_browser",
}
"""Names of options by heading, in the order of the help. The others are seldom needed."""
SELDOM = "Seldom needed"
HELP_ALL = "--help-all"


class SectionedCommand(click.Command):
    """A command whose help has headings if it has many options."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options; those that are seldom needed only with ``--help-all``."""
        options = [each for each in self.get_params(ctx) if isinstance(each, click.Option)]
        if len(options) <= MOST_ON_A_SCREEN:
            super().format_options(ctx, formatter)
            return
        seldom = list(options)
        for title, names in SECTIONS.items():
            shown = [each for name in names.split() for each in options if each.name == name or key_of(each) == name]
            seldom = [each for each in seldom if each not in shown]
            _write(ctx, formatter, title, shown)
        if ctx.meta.get(HELP_ALL):
            _write(ctx, formatter, SELDOM, seldom)
        else:
            formatter.write_paragraph()
            with formatter.indentation():
                formatter.write_text(f"{len(seldom)} more options: {ctx.command_path} {HELP_ALL}")


def key_of(option: click.Option) -> str:
    """Return the name of an option with underscores: its longest flag."""
    return max(option.opts, key=len).removeprefix("--").replace("-", "_")


def help_all(count: int) -> Iterator[click.Option]:
    """Yield the option that shows all options, for a command with this many."""
    if count > MOST_ON_A_SCREEN:
        yield click.Option(
            [HELP_ALL], is_flag=True, is_eager=True, expose_value=False, callback=_show_all, help="Show all options."
        )


def _show_all(ctx: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[HELP_ALL] = True
        click.echo(ctx.get_help())
        ctx.exit()


def _write(ctx: click.Context, formatter: click.HelpFormatter, title: str, options: Sequence[click.Option]) -> None:
    rows = [record for each in options if (record := each.get_help_record(ctx)) is not None]
    if rows:
        with formatter.section(title):
            formatter.write_dl(rows)
