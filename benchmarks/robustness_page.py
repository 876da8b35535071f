"""Tables that programs put into docs/robustness.md, each between marks with its name."""

import argparse
import re
from collections.abc import Callable, Iterable
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "robustness.md"


def put(name: str, table: str, page: Path = PAGE) -> None:
    """Replace what stands between the marks of `name` by a table; `ValueError` if the page has no such marks."""
    text = page.read_text(encoding="utf-8")
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    found, count = re.subn(f"{begin}.*{end}", lambda _: f"{begin}\n{table.strip()}\n{end}", text, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"{page} has {count} places for '{name}', not one")
    page.write_text(found, encoding="utf-8")


def rows_of(name: str, page: Path = PAGE) -> dict[str, str]:
    """Return the rows of the table between the marks of `name`, by what stands in their first column."""
    found = re.search(f"<!-- {name} -->\n(.*)<!-- end of {name} -->", page.read_text(encoding="utf-8"), re.DOTALL)
    return {line.split("|")[1].strip(): line for line in (found[1] if found else "").splitlines()}


def shown(lines: Iterable[str]) -> str:
    """Print the lines of a table as they are made and return them together."""
    made = []
    for line in lines:
        print(line, flush=True)
        made.append(line)
    return "\n".join(made)


def main_of_table(doc: str, name: str, page: Path, table: Callable[[int], Iterable[str]], count: int) -> None:
    """Print a table of so many cases of a kind, by default `count`, and put it into its page if that is asked for."""
    parser = argparse.ArgumentParser(description=doc.partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=count)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    text = shown(table(options.count))
    if options.docs:
        put(name, text, page)
