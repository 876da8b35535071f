"""The command that all commands hang on."""

import typer

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="From one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model.",
    epilog="Example: vasowave fit network.csv cycle.csv --output my-mouse",
)
