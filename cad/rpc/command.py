"""`wpcal rpc`: answer another program."""

from __future__ import annotations

import click


@click.command()
def rpc() -> int:
    """Answer requests of another program, such as a CAD program: lines of JSON on standard input and output.

    The reference page "wpcal for other programs" describes the messages. Ends when standard input is closed (code 0).
    """
    from cad.rpc.front import answer_client

    return answer_client()
