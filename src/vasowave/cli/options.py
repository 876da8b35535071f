"""Options of a command, one for every setting, with the default and the meaning that the setting itself states."""

import inspect
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, get_args, get_origin

import typer
from typer.main import get_command

import vasowave as vw
from vasowave.base.cures import FLOW_ZERO, field_of
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Place
from vasowave.base.settings import Setting, settings_of
from vasowave.cli.signatures import TYPED, with_parameters
from vasowave.study import folder as folders
from vasowave.study.folder.problems import refuse
from vasowave.study.folder.reading import Document

_NOT_FOR_ONE = ("title", "animals", "groups", "design")
"""Keys of a study file that say nothing of a single animal."""

_OF_FITS = ("walls", "beds", "starts", "method", "paper_bounds", "bounds", "model_selection", "noise_models",
            "waves_at", "inference", "pdf", "law", "quantities")  # fmt: skip
"""Settings of a fit and its report that a posterior does not know."""

_OF_RECORDINGS = ("species", "site", "catheter")
"""Settings that a recording is read by, beside those of its averaging."""

_SHOWN = (
    *("channel", "unit", "sheet", "period", "start", "end", "wedge"),
    *("species", "site", "walls", "beds", "starts", "inference", "practice", "pdf"),
)
"""Options that the help of a command with all settings shows; the others work, too; docs/study-file.md lists them."""

_SET = "set"
_SET_HELP = (
    "Any setting by its key in a study file, or any column of the table of animals; may be repeated: --set "
    "practice=paper --set calibration.bounds.beta=10:400 --set 'zero \\[mmHg]=1.5'. All of them: docs/study-file.md."
)

_REPEATED = {"outlets": "--outlet"}
"""Settings of several values, each given by an option of its own."""

CELLS = tuple(title for title, column in folders.COLUMNS.items() if column.is_option)
"""Columns of the table of animals that are options too."""

CELLS_OF_ADD = (*CELLS, "site")
"""Those of `add`; elsewhere the artery is that of the study."""

CELLS_OF_INDICES = tuple(title for title in CELLS if folders.COLUMNS[title].scope not in ("loops", "animal"))
"""Those of `indices`, which says nothing of other places, of a ventricle and of blood."""

CELLS_OF: dict[str, tuple[str, ...]] = {
    "channel": ("pressure", "flow", "ecg", "volume"),
    "unit": ("pressure", "flow", "volume"),
}
_MEANINGS = {
    "channel": "Title of the channel of pressure, flow, ecg or (of loops) volume, where titles and units leave more "
    "than one answer; may be repeated: --channel pressure='PA 2'.",
    "unit": "Unit of pressure, flow or (of loops) volume, where the file names none; may be repeated: --unit "
    "flow=ml/min.",
}

_OF_LOOPS = {
    "channel": "Title of the channel of pressure or volume, where titles and units leave more than one answer; may be "
    "repeated: --channel volume='LV vol'.",
    "unit": "Unit of pressure or volume, where the file names none; may be repeated: --unit volume=ul.",
}
_NAMED_BY_CHANNEL = ("pressure", "volume", "pressure_unit", "volume_unit")


def with_settings(name: str, command: Any) -> Any:
    """Return a command with an option for every setting; its function takes them as one mapping, `setting_values`."""
    function = command.callback.__wrapped__
    command_parameters = [
        parameter for parameter in inspect.signature(function).parameters.values() if parameter.name != "setting_values"
    ]
    options = _options_of(name)

    def called(**arguments: Any) -> None:
        setting_values = {key: arguments.pop(key) for key in options}
        if by_key := setting_values.pop(_SET, None):
            setting_values |= _by_key(setting_values, by_key)
        typed = {key: value for key, value in setting_values.items() if value not in (None, [])}
        if field_of(FLOW_ZERO) in options:
            TYPED.set(typed)
        function(**arguments, setting_values=typed)

    parameters = [inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
                  for key, kind in options.items()]  # fmt: skip
    called.__doc__ = function.__doc__
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command(name, epilog=command.epilog)(with_parameters(called, [*command_parameters, *parameters]))
    return get_command(single)


def flag(name: Any) -> str:
    """Return the option of a setting."""
    return f"--{str(name).replace('_', '-')}"


def row_cells(
    options: dict[str, Any], titles: Sequence[str] = CELLS, named: Mapping[str, Sequence[str]] = CELLS_OF
) -> dict[str, str]:
    """Take what a table of animals says in its columns out of `options`; return it as cells of such a table.

    Raises
    ------
    InputError
        A channel or unit of something else than `named`: pressure, flow or ECG.
    """
    cells = {title: options.pop(field_of(title)).strip() for title in titles if field_of(title) in options}
    for option, names in named.items():
        for text in options.pop(option, []):
            name, _, value = (piece.strip() for piece in text.partition("="))
            if name not in names or not value:
                raise InputError(f"--{option} {text}: write {' or '.join(f'{choice}=…' for choice in names)}"
                                 f"{did_you_mean(name, names)}")  # fmt: skip
            if f"{name} {option}" in cells:
                raise InputError(f"--{option} {text}: the {option} of {name} is given twice; give it once")
            cells[f"{name} {option}"] = value
    return cells


class GivenOptions(Document):
    """Settings given as options; their places are the options' names."""

    def place(self, path: Any, key: bool = False) -> Place:
        """Return the option that the value at `path` was given with."""
        words = [str(word) for word in path if str(word) not in self.values]
        if not path:  # options that contradict each other; the sentence names them
            return Place(part="options")
        return Place(part=flag((words or list(path))[0]))


def read_settings(options: Mapping[str, Any], title: str, group: str) -> "folders.StudyFile":
    """Return the settings of a study of one group, with those that the `options` say.

    Raises
    ------
    InputError
        Everything that is wrong in them, each with its option.
    """
    values: dict[str, Any] = {"title": title, "groups": [group]}
    for section, key, setting in _keys():
        if key in options:
            (values.setdefault(section, {}) if section else values)[key] = _value(setting, options[key])
    document = GivenOptions("options", values)
    settings = folders.validated(document)
    refuse(document.problems)
    assert settings is not None
    return settings


def _options_of(name: str) -> dict[str, Any]:
    """Return the options of a command; what studies need takes seconds to load, and images need none of it."""
    if name == "extract":
        from vasowave.lung.options import Options

        return {key: _option(key, setting) for key, setting in settings_of(Options).items()}
    if name == "add":
        return _row_options((), CELLS_OF_ADD)
    if name == "loops":
        typed = {name: Setting(dict, {}, meaning) for name, meaning in _OF_LOOPS.items()}
        plain = {key: setting for key, setting in settings_of(vw.LoopReading).items() if key not in _NAMED_BY_CHANNEL}
        return {key: _option(key, setting, "recording") for key, setting in (typed | plain).items()}
    keys = [(section, key, setting) for section, key, setting in _keys() if _belongs(name, section, key)]
    shown, titles = ((*_SHOWN, "subject_row"), CELLS_OF_INDICES) if name == "indices" else (_SHOWN, CELLS)
    options = _row_options(shown, titles) | {
        key: _option(key, setting, section or "more", key not in _SHOWN) for section, key, setting in keys
    }
    return options | {_SET: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help=_SET_HELP)]}


def _belongs(name: str, section: str, key: str) -> bool:
    """Whether a command knows a setting."""
    if name == "indices":
        return section == "averaging" or key in _OF_RECORDINGS
    return name != "posterior" or key not in _OF_FITS


def _row_options(shown: Sequence[str], titles: Sequence[str]) -> dict[str, Any]:
    several = {name: Setting(dict, {}, meaning) for name, meaning in _MEANINGS.items()}
    plain = {field_of(title): Setting(str, None, f"{folders.COLUMNS[title].meaning} ({title})") for title in titles}
    settings = (several | plain).items()
    return {name: _option(name, setting, "recording", bool(shown) and name not in shown) for name, setting in settings}


def _keys() -> list[tuple[str, str, Setting]]:
    """Return section (empty for the top level), name and declaration of every setting of one animal's study."""
    keys: list[tuple[str, str, Setting]] = []
    for name, setting in settings_of(folders.StudyFile).items():
        if name in _NOT_FOR_ONE:
            continue
        if setting.section:
            keys += [(name, key, inner) for key, inner in settings_of(setting.section).items()]
        else:
            keys.append(("", name, setting))
    return keys


def _option(key: str, setting: Setting, panel: str | None = None, hidden: bool = False) -> Any:
    """Return the annotation of an option; its text is read as the study file's is."""
    name = flag(key)
    several = [_REPEATED[key]] if key in _REPEATED else []
    arguments: dict[str, Any] = {"help": setting.meaning.replace("[", r"\["), "show_default": _shown(setting.default)}
    arguments |= {"rich_help_panel": panel, "hidden": hidden} if panel else {}
    if isinstance(setting.default, bool) or bool in get_args(setting.kind):
        return Annotated[bool | None, typer.Option(f"{name}/--no-{name[2:]}", **arguments)]
    if isinstance(setting.default, dict):
        return Annotated[list[str] | None, typer.Option(name, metavar="NAME=VALUE", **arguments)]
    kind: Any = list[str] if several else str
    return Annotated[kind | None, typer.Option(*several, name, metavar="VALUE", **arguments)]


def _by_key(options: Mapping[str, Any], given: list[str]) -> dict[str, Any]:
    """Return what was given by keys of a study file, or columns of its table, as options.

    Raises
    ------
    InputError
        A key that there is not or was given before, or no value.
    """
    mappings = {key for _, key, setting in _keys() if isinstance(setting.default, dict)} | {*CELLS_OF}
    keys = {f"{section}.{key}".lstrip("."): key for section, key, _ in _keys()} | {key: key for key in options}
    keys |= {title: folders.ERRORS.get(title, field_of(title)) for title in folders.COLUMNS}
    keys = {key: option for key, option in keys.items() if option in options}  # a posterior has no starts
    set_options: dict[str, Any] = {}
    for text in given:
        key, _, value = (piece.strip() for piece in text.partition("="))
        parent, _, name = key.rpartition(".")
        if key.endswith((" channel", " unit")):
            name, _, parent = key.rpartition(" ")
        if not value:
            raise InputError(f"--set {text}: no value is given; write --set {key or 'walls'}=VALUE")
        if key in keys and (keys[key] in set_options or options[keys[key]] not in (None, [])):
            raise InputError(f"--set {text}: {keys[key]} is given twice; give it once")
        if key not in keys and keys.get(parent) in mappings:
            set_options[keys[parent]] = [
                *(set_options.get(keys[parent]) or options[keys[parent]] or []),
                f"{name}={value}",
            ]
        elif key in keys:
            set_options[keys[key]] = [value] if keys[key] in mappings else value
        else:
            raise InputError(
                f"--set {text}: this command has no setting '{key}'{did_you_mean(key, list(keys))}; give a key of a "
                "study file (docs/study-file.md), a column of the table of animals, or see --help"
            )
    return set_options


def _shown(default: Any) -> str | bool:
    if default is None or default == {}:
        return False
    if isinstance(default, list | tuple):
        return ",".join(map(str, default))
    return f"{default:g}" if isinstance(default, float) else str(default).lower()


def _value(setting: Setting, option_value: Any) -> Any:
    """Return what stands in a study file for the text of an option; ``low:high`` and ``one,other`` are lists."""
    if isinstance(option_value, list):  # one mapping, whose entries were given one by one
        pairs = [text.partition("=") for text in option_value]
        return {name.strip(): _list(value, ":") if ":" in value else value for name, _, value in pairs}
    return _list(option_value, ",") if _is_list(setting.kind) and isinstance(option_value, str) else option_value


def _is_list(kind: Any) -> bool:
    return get_origin(kind) in (tuple, list) or any(map(_is_list, get_args(kind)))


def _list(text: str, separator: str) -> list[str]:
    return [word.strip() for word in text.split(separator)]
