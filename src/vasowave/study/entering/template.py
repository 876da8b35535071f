"""A new study: a commented study file, its schema for editors, a table of animals that is empty or of virtual mice."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.io.files import made_inside, write_file, write_folder
from vasowave.base.io.textfile import read_bytes
from vasowave.base.settings import Setting, schema_of, settings_of, summary
from vasowave.base.species import known_species
from vasowave.catheter.synthetic_files import SYNTHETIC_NOTICE
from vasowave.study.datasets.virtual import virtual_cohort
from vasowave.study.datasets.virtual_files import write_virtual_cohort
from vasowave.study.folder.animal_columns import COLUMNS, REQUIRED_COLUMNS
from vasowave.study.folder.places import STUDY_FILE
from vasowave.study.folder.problems import refuse
from vasowave.study.folder.reading import parse_document, parse_settings
from vasowave.study.folder.settings import StudyFile

SCHEMA_FILE = "study.schema.json"
FOLDERS = ("networks", "recordings")
_COMMENT_WIDTH = 100  # letters of a line of comment
_MARK = "truth.csv"  # a lab never has this file


def new_study(folder: Path, groups: Sequence[str] = ("CTL", "HPH"), species: str = "mouse") -> list[Path]:
    """Write the files of a new study and return them.

    Raises
    ------
    InputError
        One of them exists already; nothing was written then. The folder cannot be written. A label that cannot be one.
        An unknown species.
    """
    folder = Path(folder)
    known_species(species)
    texts = {STUDY_FILE: study_text(groups, species), SCHEMA_FILE: schema_text(), "animals.csv": animals_text()}
    refuse(parse_settings(texts[STUDY_FILE].encode())[1])
    for name in texts:
        if (folder / name).exists():
            raise InputError(f"{folder / name} exists already; give another folder, nothing was changed")
    with write_folder(folder) as fresh:
        for name, text in texts.items():
            write_file(fresh / name, text)
    for name in FOLDERS:
        made_inside(folder, name)
    return [folder / name for name in texts]


def study_text(groups: Sequence[str] = ("CTL", "HPH"), species: str = "mouse") -> str:
    """Return ``study.yaml`` with every key, its meaning and its default."""
    lines = [
        f"# yaml-language-server: $schema={SCHEMA_FILE}",
        "# A vasowave study. Every key has its default; lines may be left out.",
        "# The animals stand in animals.csv, their files in networks/ and recordings/.",
        "# Then: vasowave check, vasowave run.",
    ]
    for name, setting in settings_of(StudyFile).items():
        lines.append("")
        if setting.section:
            lines += [*_comment(summary(setting.section), ""), f"{name}:"]
            for key, inner in settings_of(setting.section).items():
                lines += [*_comment(inner.meaning, "  "), *_key(key, inner, "  ")]
        else:
            shown = setting._replace(default={"groups": list(groups), "species": species}.get(name, setting.default))
            lines += [*_comment(setting.meaning, ""), *_key(name, shown, "")]
    return "\n".join(lines) + "\n"


def with_groups(path: Path, groups: Sequence[str]) -> str:
    """Return the text of a study file with other groups; raises as `with_values`."""
    return with_values(path, {("groups",): written(list(groups))})


def with_values(path: Path, values: Mapping[tuple[str, ...], str]) -> str:
    """Return the text of a study file with other values of some keys; everything else stays as it is.

    Parameters
    ----------
    path : Path
    values : mapping of tuple of str to str
        By the name of the key, or the section that it stands in and its name; as YAML, on one line.

    Raises
    ------
    InputError
        A value is none that its key may have, or what stands there takes several lines.
    """
    text = read_bytes(path).decode("utf-8-sig")
    for key, value in values.items():
        text = _with_value(text, path, key, value)
    return text


def _with_value(text: str, path: Path, key: tuple[str, ...], value: str) -> str:
    before = parse_document(text.encode(), str(path))
    lines, line = text.splitlines(), f"{'  ' * (len(key) - 1)}{key[-1]}: {value}"
    key_exists = any(key_path == key for key_path in before.keys)
    if key_exists:
        number = before.place(key, key=True).line - 1
        remark = _remark(lines[number])
        indent = lines[number][: len(lines[number]) - len(lines[number].lstrip())]
        lines[number] = f"{indent}{line.lstrip()}{remark}"
    elif len(key) > 1 and key[:-1] in before.keys:
        lines.insert(before.place(key[:-1], key=True).line, line)
    else:
        lines += [*(f"{name}:" for name in key[:-1]), line]
    changed = "\n".join([*lines, ""])
    after, wished = parse_document(changed.encode(), str(path)), parse_document(f"value: {value}".encode(), "")
    rest_is_same = _without(after.values, key) == _without(before.values, key)
    if not after.problems and rest_is_same:
        refuse(parse_settings(changed.encode(), str(path))[1])
    if after.problems or not rest_is_same or _value_of(after.values, key) != wished.values.get("value"):
        raise InputError(f"{path}: '{'.'.join(key)}' is written over several lines; write there: {line.lstrip()}")
    return changed


def _remark(line: str) -> str:
    """Return what stands behind the value of a line of YAML, empty where the value does not end on it."""
    import yaml

    behind = yaml.BlockEndToken, yaml.StreamEndToken
    try:
        ends = [token.end_mark.column for token in yaml.scan(line) if not isinstance(token, behind)]
    except yaml.YAMLError:
        return ""
    return line[max(ends) :].rstrip()


def _value_of(values: Any, key: Sequence[str]) -> Any:
    for name in key:
        values = values.get(name) if isinstance(values, dict) else None
    return values


def _without(values: dict[str, Any], key: Sequence[str]) -> dict[str, Any]:
    """Return the values without that of one key; a section that holds nothing else counts as none."""
    result = {name: value for name, value in values.items() if name != key[0]}
    inner = values.get(key[0])
    if len(key) > 1 and isinstance(inner, dict) and (inner_result := _without(inner, key[1:])):
        result[key[0]] = inner_result
    return result


def schema_text() -> str:
    """Return the JSON schema of ``study.yaml``, with which editors complete and check it."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema_of(StudyFile)}
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def animals_text() -> str:
    """Return ``animals.csv`` without animals: what the usual columns mean, the names of all others, and a header."""
    usual = ["animal", "group", "network", "recording", "flow", "kind", "period [s]"]
    lines = ["# One row per animal. Files are relative to this folder. Columns that are not needed may be left out."]
    for title in usual:
        needed = " (needed)" if title in REQUIRED_COLUMNS else ""
        lines.append(f"#   {title}{needed}: {COLUMNS[title].meaning}")
    further = f"Further columns: {', '.join(title for title in COLUMNS if title not in usual)}."
    lines += [
        *_comment(further + " What each means: docs/study-file.md, and the workbench above each.", ""),
        "# Examples:",
        "#   CTL 1,CTL,networks/control.csv,recordings/ctl-1.csv,,cycle,",
        "#   CTL 2,CTL,networks/control.csv,recordings/ctl-2-pressure.dat,recordings/ctl-2-flow.dat,cycle,0.11",
        "#   HPH 1,HPH,networks/hypoxic.csv,recordings/hph-1.txt,,raw,",
        ",".join(usual),
    ]
    return "\n".join(lines) + "\n"


def _comment(text: str, indent: str) -> list[str]:
    return [f"{indent}# {line}" for line in wrap(text, _COMMENT_WIDTH)]


def _key(name: str, setting: Setting, indent: str) -> list[str]:
    lines = [f"{indent}{name}:{'' if setting.default is None else ' ' + written(setting.default)}"]
    return lines + ([] if setting.example is None else [f"{indent}# {name}: {written(setting.example)}"])


def written(value: Any) -> str:
    """Return a value as YAML on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_within, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_within(key)}: {_within(inner)}' for key, inner in value.items())}}}"
    if isinstance(value, float):
        text = f"{value:g}"
        return text if "." in text else text.replace("e", ".0e")  # 1e-7 is text to many readers of YAML
    return str(value)


def _within(value: Any) -> str:
    """Return a value as YAML within brackets or braces, where a comma would end it."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) and "," in value else written(value)


def write_virtual_study(folder: Path, starts: int = 4, seed: int = 1) -> Path:
    """Write the files of twelve virtual mice and a study file that fits each of them from `starts` starts.

    Returns
    -------
    Path
        The study file. The same arguments write the same bytes, so a study that was interrupted goes on.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
    """
    folder = Path(folder)
    if folder.is_file():
        raise InputError(f"{folder} is a file; give the name of a folder")
    if folder.exists() and any(folder.iterdir()) and not (folder / _MARK).exists():
        raise InputError(f"{folder} is not empty and not the study of virtual mice; give another folder")
    write_virtual_cohort(virtual_cohort(seed), folder)
    study = folder / STUDY_FILE
    write_file(
        study,
        f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
        f"# {SYNTHETIC_NOTICE}\n"
        "title: Virtual cohort of 7 + 5 mice (SYNTHETIC)\n"
        "calibration:\n"
        f"  starts: {starts}\n",
    )
    write_file(folder / SCHEMA_FILE, schema_text())
    return study
