"""What an animal and a group may be called, so that every file, figure, table and program takes the name."""

import re
import unicodedata

from vasowave.errors import InputError

LONGEST = 60  # letters that fit beside a figure
_NAME = re.compile(r"\w[\w .,+()-]*")


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
    if len(name) > LONGEST:
        raise InputError(f"'{name[:20]}…' has {len(name)} characters; at most {LONGEST} fit beside a figure")
    return name
