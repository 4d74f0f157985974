"""Every command with its arguments and options, as the program itself has them."""

from __future__ import annotations

from typing import Any

import typer

from sim.cli.commands import app


def reference() -> str:
    """A section for each command."""
    group: Any = typer.main.get_command(app)
    return "".join(_command(name, command) for name, command in group.commands.items() if not command.hidden)


def _command(name: str, command: Any) -> str:
    context = command.make_context(name, [], resilient_parsing=True)
    usage = " ".join(piece for piece in command.collect_usage_pieces(context) if piece != "[OPTIONS]")
    words = "\n\n".join(_one_line(part) for part in (command.help or "").split("\n\n"))
    records = (one.get_help_record(context) for one in command.params if one.param_type_name == "option")
    rows = [f"| `{_one_line(spelt)}` | {_one_line(said)} |\n" for spelt, said in filter(None, records)]
    table = "\n| option | |\n|---|---|\n" + "".join(rows) if rows else ""
    return f"\n### `{name}`\n\n`shortfinal {name} {usage}`\n\n".replace(" `\n", "`\n") + f"{words}\n{table}"


def _one_line(text: str) -> str:
    return " ".join(text.split()).replace("|", "/")


if __name__ == "__main__":
    print(reference())
