"""What the Lung desk can change: lines of the file of edits that `vasowave extract` reads, and the folder it writes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge, Gt, MaxLen, MinLen

from vasowave.errors import InputError
from vasowave.imaging.places import written
from vasowave.io.files import made_inside, write_file
from vasowave.settings import settings_class
from vasowave.workbench.desk import EDITS
from vasowave.workbench.lungs import LUNGS, Wishes, edits_of

if TYPE_CHECKING:
    from vasowave.workbench.actions import Workplace

Image = Annotated[str, MinLen(1), MaxLen(500)]
Point = tuple[float, float, float]
_HEAD = "# Corrections of the tree; places are x y z as a viewer shows the image."
_NEW_TREE = ("root", "outlet")  # after which the axes are looked for anew


@settings_class
class EditTree:
    """Write one edit; places are x, y, z in cm along the image's axes, a radius is in cm.

    Where the vessels are known, the edit is tried at once: one that cannot be made is refused, and the file stays.
    """

    image: Image
    action: Literal["root", "outlet", "remove", "cut", "merge", "move", "radius"]
    point: Point
    to: Point | None = None
    radius: Annotated[float, Gt(0)] | None = None

    def do(self, at: "Workplace") -> str:
        """Do it."""
        if (self.action == "move") != (self.to is not None) or (self.action == "radius") != (self.radius is not None):
            raise InputError("a move has a place to go to, a radius its size, and other edits have neither")
        desk, lungs = at.desk, at.lungs
        numbers = [_numbers(at, self.image, self.point)]
        numbers += [] if self.to is None else [_numbers(at, self.image, self.to)]
        numbers += [] if self.radius is None else [f"{self.radius:.6g}"]
        line = " ".join([self.action, *numbers])
        path, wishes = edits_of(desk, self.image), lungs.finds(desk, self.image)
        made_inside(desk.folder, EDITS)
        with desk.changing(f"{line} in {path.name}", path):
            lines = [one for one in _lines(path) if not (self.action == "root" and one.split()[:1] == ["root"])]
            write_file(path, "\n".join([*(lines or [_HEAD]), *_unit_cm(lines), line, ""]))
            if wishes is not None and self.action not in _NEW_TREE:
                lungs.extracted(desk, self.image, wishes)
        return f"{line}, in {EDITS}/{path.name}"


@settings_class
class ForgetEdit:
    """Take one line out of the file of edits; `text` is what the page showed in it."""

    image: Image
    line: Annotated[int, Ge(1)]
    text: Annotated[str, MaxLen(2000)]

    def do(self, at: "Workplace") -> str:
        """Do it."""
        path = edits_of(at.desk, self.image)
        with at.desk.changing(f"forget '{self.text}' of {path.name}", path):
            lines = _lines(path)
            if self.line > len(lines) or lines[self.line - 1] != self.text:
                raise InputError(f"{path.name} was changed elsewhere meanwhile; look at it, then change it again")
            write_file(path, "\n".join([*lines[: self.line - 1], *lines[self.line :], ""]))
        return f"without '{self.text}'"


@settings_class
class WriteLung:
    """Write network, lines, mask and page of an image's vessels, as `vasowave extract` does."""

    image: Image
    wishes: dict[str, Any]

    def do(self, at: "Workplace") -> str:
        """Do it."""
        at.lungs.write(at.desk, self.image, Wishes(**self.wishes))
        return f"{LUNGS}/{self.image}/network.csv is written; choose it as the network of an animal"


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def _unit_cm(lines: list[str]) -> list[str]:
    """Return the line that makes cm the unit, where another one holds at the end."""
    units = [words[1] for line in lines if (words := line.split("#")[0].split())[:1] == ["unit"] and len(words) == 2]
    return ["unit cm"] if units and units[-1] != "cm" else []


def _numbers(at: "Workplace", image: str, point: Point) -> str:
    return written(at.lungs.own(at.desk, image, point)[::-1] + 0.0).replace(",", " ")


LUNG_ACTIONS = {"edit-tree": EditTree, "forget-edit": ForgetEdit, "write-lung": WriteLung}
"""By the name that the page gives."""
