"""The command ``shortfinal``: every verb of the simulation, one sentence for every fault.

``options`` are what several commands share. ``flying``: run, judge, record; ``studying``: study, resume; ``claims``;
``compare``; ``writing``: validate, new, schema; ``looking``: list, explain; ``examining``: contract, doctor;
``identify``; ``export``. ``hints`` says where a command line that is none leads.
"""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from sim.cli.commands.claims import claims
from sim.cli.commands.compare import compare
from sim.cli.commands.examining import contract, doctor
from sim.cli.commands.export import export
from sim.cli.commands.flying import judge, record, run
from sim.cli.commands.hints import hint
from sim.cli.commands.identify import identify
from sim.cli.commands.looking import explain, list_
from sim.cli.commands.studying import resume, study
from sim.cli.commands.writing import new, schema, validate
from sim.cli.endings import (
    BAD_INPUT,
    STOPPED,
    UNFORESEEN,
    Interrupted,
    Unwritable,
    stopped_by_signals,
    told_apart,
    unforeseen,
    written,
)
from sim.cli.terminal import prepared_streams, say
from sim.errors import OutputError, ScenarioError, printable
from sim.workers.blas import one_thread

UsageError: Any = typer.BadParameter.__base__  # typer does not export it

app = typer.Typer(
    name="shortfinal",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help, in less than half the time
    context_settings={"help_option_names": ["-h", "--help"]},
)
COMMANDS = (  # as the help lists them
    *(run, judge, record),
    *(study, resume, claims, compare),
    *(validate, new, list_, explain, schema),
    *(contract, doctor, identify, export),
)


def _version(asked: bool) -> None:
    if asked:
        from sim.versions import __version__

        typer.echo(f"shortfinal {__version__}")
        raise typer.Exit


@app.callback()
def shortfinal(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version, and end.")
    ] = False,
) -> None:
    """Fly an approach in JSBSim under a bank-limited route autopilot, watch it, track it, judge it.

    Research software, not for operational use.
    """


for _command in COMMANDS:
    app.command(_command.__name__.rstrip("_"))(told_apart()(_command))


def main() -> None:
    """Entry point: faults become sentences on standard error, each kind with an exit code of its own."""
    one_thread()
    prepared_streams()
    with stopped_by_signals() as came:
        code = _ended(came)
        if came and code:  # typer has a code of its own for what comes while it reads the words
            code = STOPPED + came[0]
        sys.exit(code)


def _ended(came: list[int]) -> Any:
    """The exit code of the command that was asked for; ``came`` are the signals that were to stop it."""
    try:
        return written(lambda: app(standalone_mode=False))
    except BaseException as error:
        if came:  # extensions that are being imported make other errors of it
            say("stopped")
            return STOPPED + came[0]
        return _told(error)


def _told(error: BaseException) -> int:
    """What went wrong, in sentences, and its exit code."""
    match error:
        case SystemExit():
            say("shortfinal: a part or a model ends the process; it must raise an error instead")
            return BAD_INPUT
        case Interrupted():
            say("stopped")
            return error.code
        case Unwritable():
            say(f"shortfinal: {error}")
            return UNFORESEEN
        case UsageError():
            told = error.format_message()
            if "\n" in told:  # nothing was asked, and the help is the answer
                typer.echo(told)
            else:
                say(f"shortfinal: {printable(told).rstrip('.')}; {hint(error, told)}")
            return BAD_INPUT
        case ScenarioError() | OutputError():
            for line in str(error).splitlines():
                say(f"shortfinal: {printable(line)}")
            return BAD_INPUT
        case _:
            return unforeseen(error)
