"""Put the numbers of docs/paper/manuscript.md into it, from the tables that benchmarks wrote, and draw its figure.

    uv run python benchmarks/paper_numbers.py

A number of the manuscript stands before a mark with its name, as in `0.061<!-- false.this -->`. `SOURCES` says on which
page it is found, and where. `numbers.json` holds all of them with the commit that last changed that page.
"""

import json
import re
import subprocess
from pathlib import Path

from robustness_page import rows_of

ROOT = Path(__file__).parents[1]
DOCS, PAPER = ROOT / "docs", ROOT / "docs" / "paper"
MARKED = re.compile(r"(?P<value>\S+(?: to \S+)?(?: (?:%|s|mmHg))?)(?P<mark><!-- (?P<name>[\w.]+) -->)")

VALIDATION, COVERAGE, COMPARISONS = "validation.md", "coverage.md", "comparisons.md"
ACCURACY, IMAGING, ROBUSTNESS = "performance.md", "imaging.md", "robustness.md"
SOURCES = {
    "fit.radii": (COVERAGE, r"radii 5 % in common .*?\| 40 \| \*\*(\d+)\*\*"),
    "fit.zero": (COVERAGE, r"zero 1 mmHg off .*?\| 40 \| .*?\| \*\*(\d+)\*\*"),
    "ranks.linear": (COVERAGE, r"\| linear \| 200 \| R_T .*?\| (\d+) \(≥"),
    "ranks.tangent": (COVERAGE, r"\| tangent \| 200 \| R_T .*?\| (\d+) \(≥"),
    "ranks.power": (COVERAGE, r"\| power \| 200 \| R_T .*?\| (\d+) \(≥"),
    "told.not": (COVERAGE, r"`flow_gain_sd`: 0.07 \| fit, not told \| 200 \| ([\d.]+)"),
    "told.fit": (COVERAGE, r"`flow_gain_sd`: 0.07 \| fit, told \| 200 \| ([\d.]+)"),
    "solver.authors": (VALIDATION, r"at the inlet, (0.02 mmHg) elsewhere"),
    "solver.carotid": (VALIDATION, r"three places \| ([\d.]+ %) r.m.s."),
    "solver.aorta": (VALIDATION, r"upper thoracic aorta \| ([\d.]+ %)"),
    "solver.bifurcation": (VALIDATION, r"five places \| ([\d.]+ %)"),
    "solver.adan": (ACCURACY, r"ADAN56.*?52 to 154 \| ([\d.]+) \("),
    "solver.repeated": (ACCURACY, r"\| all \| 2004 .*?\| (\d+) \| \d+ \| \d+ \| [\d.]+ % \|"),
    "solver.silent": (ACCURACY, r"\| all \| 2004 .*?\| \d+ \| \d+ \| (\d+) \| [\d.]+ % \|"),
    "speed.fit": (ACCURACY, r"led by the linear model first \| .*?\| \d+, (0.66 s) \|"),
    "speed.posterior": (ACCURACY, r"CPU, s \| ([\d.]+ to [\d.]+) \|"),
    "speed.demo": (ACCURACY, r"everything to compile; kernels there \| (\d+ s);"),
    "false.this": (COMPARISONS, r"\| 7 \+ 5, × 2 \| ([\d.]+)"),
    "false.welch": (COMPARISONS, r"\| 7 \+ 5, × 2 \| [\d.]+ \| [\d.]+ \| ([\d.]+)"),
    "false.relabeled": (COMPARISONS, r"\| 7 \+ 5, × 2 \| [\d.]+ \| [\d.]+ \| [\d.]+ \| ([\d.]+)"),
    "image.this": (COMPARISONS, r"\| 5 %, animals differ by 10 % \| ([\d.]+)"),
    "image.welch": (COMPARISONS, r"\| 5 %, animals differ by 10 % \| [\d.]+ \| [\d.]+ \| ([\d.]+)"),
    "twice.this": (COMPARISONS, r"two recordings of each mouse, 7 \+ 5 \| ([\d.]+)"),
    "twice.usual": (COMPARISONS, r"two recordings of each mouse, 7 \+ 5 \| [\d.]+ \| ([\d.]+)"),
    "skewed.seven": (COMPARISONS, r"skewed \(exponential logarithms\) \| ([\d.]+)"),
    "skewed.twelve": (COMPARISONS, r"skewed \(exponential logarithms\) \| [\d.]+ \| [\d.]+ \| ([\d.]+)"),
    "image.volumes": (IMAGING, r"(\d+) volumes of 63 kinds"),
    "image.right": (IMAGING, r"(\d+) have the right tree"),
    "others.guided": (IMAGING, r"\| all \| [^|]*\| [^|:]*: ([\d.]+) /"),
    "others.vmtk": (IMAGING, r"\| all \| [^|]*\| [^|]*\| [^|]*\| [^|]*\| [^|:]*: ([\d.]+) /"),
    "mutants": (ROBUSTNESS, r"notice (\d+) of 200 changed lines"),
}
"""By the name of a number: the page that holds it, and a pattern of its line with the number in brackets."""


def found(name: str) -> str:
    """Return a number as its page has it; `ValueError` where the page has no such line."""
    page, pattern = SOURCES[name]
    if (line := re.search(pattern, (DOCS / page).read_text("utf-8"))) is None:
        raise ValueError(f"docs/{page} has no line for {name!r}; mend its pattern in benchmarks/paper_numbers.py")
    return line[1]


def filled(text: str) -> str:
    """Return a text with the number before each mark as its page has it; units stay."""

    def put(match: re.Match[str]) -> str:
        number, unit = found(match["name"]), re.search(r" (?:%|s|mmHg)$", match["value"])
        return number + (unit[0] if unit and not number.endswith(unit[0]) else "") + match["mark"]

    return MARKED.sub(put, text)


def commit_of(page: str) -> str:
    """Return the commit that last changed a page."""
    command = ["git", "log", "-1", "--format=%h", "--", f"docs/{page}"]
    return subprocess.check_output(command, cwd=ROOT, text=True).strip()


def shares(name: str, page: str, first: int, second: int, *, within: str = "") -> list[tuple[str, float, float]]:
    """Return the rows of a table of a page: what stands in front, and the numbers of two of its columns."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in rows_of(name, DOCS / page).values()]
    return [(row[0], float(row[first]), float(row[second])) for row in rows[2:] if within in row[0]]


def told_and_not() -> list[tuple[str, float, float]]:
    """Return by wrong assumption how often fits hold the wave speed, told of it and not."""
    lines = (DOCS / COVERAGE).read_text("utf-8").splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| `")]
    held = {
        (row[0].split("`")[1].removesuffix("_sd").replace("_", " "), row[1]): float(row[5])
        for row in cells
        if row[1].startswith("fit")
    }
    return [(name, held[name, "fit, told"], held[name, "fit, not told"]) for name, how in held if how == "fit, told"]


def draw(path: Path) -> None:
    """Draw the figure of the manuscript."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    panels = [(shares("designs", COMPARISONS, 1, 2), "vasowave", "usual tests", "share of cohorts with an effect"),
              (told_and_not(), "told", "not told", "intervals (95 %) that hold the wave speed")]  # fmt: skip
    figure, axes = plt.subplots(1, 2, figsize=(11, 6), width_ratios=(1.2, 1), layout="constrained")
    for axis, (rows, first, second, label) in zip(axes, panels, strict=True):
        names, ours, others = zip(*reversed(rows), strict=True)
        axis.plot(others, names, "o", color="#d55e00", markerfacecolor="none", label=second)
        axis.plot(ours, names, "o", color="#0072b2", label=first)
        axis.set_xlabel(label)
        axis.tick_params(axis="y", labelsize=7)
        axis.grid(axis="x", alpha=0.3)
        axis.legend(loc="upper right" if first == "vasowave" else "upper left")
    axes[0].axvspan(0.05 - 0.02, 0.05 + 0.02, color="0.9", zorder=0)
    axes[1].axvline(0.95, color="0.6", zorder=0)
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)


def main() -> None:
    """Write manuscript, numbers and figure."""
    manuscript = PAPER / "manuscript.md"
    manuscript.write_text(filled(manuscript.read_text("utf-8")), "utf-8")
    commits = {page: commit_of(page) for page, _ in SOURCES.values()}
    numbers = {
        name: {"value": found(name), "page": f"docs/{page}", "commit": commits[page]}
        for name, (page, _) in sorted(SOURCES.items())
    }
    (PAPER / "numbers.json").write_text(json.dumps(numbers, indent=1, ensure_ascii=False) + "\n", "utf-8")
    draw(PAPER / "errors.png")


if __name__ == "__main__":
    main()
