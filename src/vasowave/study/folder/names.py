"""Names that an animal and a group may have, so that every file, figure, table and program takes the name."""

import re
import unicodedata

from vasowave.base.errors import InputError

MAX_NAME_LETTERS = 60  # letters that fit beside a figure
_EDGE_CHARACTERS = " .,_+-("  # signs that neither begin nor end a name
_NAME = re.compile(r"\w[\w .,+()-]*")


def plain_name(stem: str) -> str:
    """Return a file's stem as a name: signs that a name cannot have become blanks."""
    plain = "".join(
        sign if sign.isalnum() or sign in " .,_+-()" else " " for sign in unicodedata.normalize("NFC", stem)
    )
    plain = plain.lstrip(_EDGE_CHARACTERS + ")").rstrip(_EDGE_CHARACTERS)
    plain = plain if "(" in plain else plain.rstrip(_EDGE_CHARACTERS + ")")
    return checked_name(plain[:MAX_NAME_LETTERS].strip() or "animal")


def checked_name(text: str) -> str:
    """Return a name in the form in which its letters have one code each (Unicode's NFC).

    Raises
    ------
    InputError
        A sign that a file system, a figure or a spreadsheet would take for something else, or more than 60 characters.
    """
    name = unicodedata.normalize("NFC", text)
    if not _NAME.fullmatch(name):
        raise InputError(f"'{text}': a name consists of letters, digits, blanks and . , _ + - ( )")
    if len(name) > MAX_NAME_LETTERS:
        raise InputError(f"'{name[:20]}…' has {len(name)} characters; at most {MAX_NAME_LETTERS} fit beside a figure")
    return name
