"""Power of a study by the number of its animals."""

from typing import TYPE_CHECKING

from vasowave.figures.style import FAINT, NARROW, color_stops, label_axes, new_figure, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vasowave.cohort.planning import Plan

_DASHES = ("solid", (0, (5, 2)), (0, (1, 1)), (0, (5, 1, 1, 1)))


def planned_figure(plan: "Plan") -> "Figure":
    """Draw how often each quantity's effect is shown, by the animals of each group."""
    with style():
        figure = new_figure(NARROW, 7)
        ax = figure.subplots()
        ax.axhline(plan.settings.power, color=FAINT, lw=0.9)
        colors = color_stops(1 + len(plan.powers.columns))
        for place, (name, powers) in enumerate(plan.powers.items()):
            red, green, blue = (part / 255 for part in colors[place])
            ax.plot(powers.index, powers, color=(red, green, blue), ls=_DASHES[place % len(_DASHES)], label=str(name))
        ax.set_xscale("log")
        ax.set_xticks([3, 5, 10, 20, 40, 60], ["3", "5", "10", "20", "40", "60"])
        ax.minorticks_off()
        ax.set_ylim(0, 1.02)
        ax.legend(loc="lower right")
        label_axes(
            ax,
            "pairs [1]" if plan.settings.pairs is not None else "animals of each group [1]",
            f"power to show a ratio of {plan.settings.effect:g} [1]",
        )
    return figure
