"""What images unlike the phantom need: vessels that bend, fade and narrow, frames of zeros, slices of any distance."""

from dataclasses import fields

from typer import Context
from typer.main import get_command

from vasowave.cli import app
from vasowave.lung import Options


def test_every_setting_is_an_option_of_the_command_with_the_same_default():
    command = get_command(app)
    _, extract, _ = command.resolve_command(Context(command), ["extract"])
    options = {one.name: one for one in extract.params}
    for entry in fields(Options):
        assert options[entry.name].help
        assert options[entry.name].default is None  # then the setting's own default holds, which the help shows
        default = f"{entry.default:g}" if isinstance(entry.default, float) else str(entry.default)
        assert default in str(options[entry.name].show_default) or entry.default is None
