"""Draw figures of the reference pages, named like functions below, as SVG: `python draw_details.py wedge`."""

import sys
import warnings
from dataclasses import replace

import draw
import matplotlib.pyplot as plt
import numpy as np
from draw import fitted, known
from scipy.stats import t as student

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording
from vasowave.catheter.check import Catheter
from vasowave.pulse.analysis import operating_point
from vasowave.pulse.cycle import harmonic_errors
from vasowave.pulse.model import LinearWall

BLUE = "#0072b2"
WIDE = (6.9, 2.6)


def panels(columns=2, **more):
    """Return a figure of one row."""
    return plt.subplots(1, columns, figsize=WIDE, layout="constrained", **more)


def label(ax, **where):
    """Name the lines of a panel."""
    ax.legend(frameon=False, fontsize=7, **where)


def root_of(model, inflow, **how):
    """Return the waves at the inlet of the root."""
    return vw.simulate(model, inflow, vw.Numerics(**how)).sel(vessel=model.network.name[0], station="inlet")


def swept():
    """What the resistance of the beds does to the pressure at the root, at two stiffnesses."""
    _, mouse, fit = fitted()
    table = vw.sweep(fit.model, mouse, {"R_T": list(np.linspace(60, 140, 5)), "beta": [40.0, 80.0]})
    pressure = table.root_pressure
    figure, axes = panels()
    for beta, dash in ((40.0, "o-"), (80.0, "s--")):
        one = pressure.sel(beta=beta)
        axes[0].plot(table.R_T, one.mean("time"), dash, color="black", ms=3, label=f"β = {beta:.0f} mmHg")
        axes[1].plot(table.R_T, one.max("time") - one.min("time"), dash, color="black", ms=3)
    axes[0].set(xlabel="R_T [mmHg s/ml]", ylabel="mean pressure [mmHg]")
    axes[1].set(xlabel="R_T [mmHg s/ml]", ylabel="pulse pressure [mmHg]", ylim=(0, None))
    label(axes[0])
    return figure


def foretold():
    """What less resistance of the beds does to pressure and flow at the inlet."""
    _, _, fit = fitted()
    return vw.predict(fit, {"R_T": 0.7}, draws=0).figure()


def measured_next():
    """By which factor each interval of a fit would shrink with further measurements."""
    _, _, fit = fitted()
    expected = fit.expected_precision(["2"])
    factors = expected.table[[*expected.measurements]]
    figure, ax = plt.subplots(figsize=(6.9, 3.4), layout="constrained")
    ax.imshow(factors, cmap="gray", vmin=0, vmax=1, aspect="auto")
    for (row, column), factor in np.ndenumerate(factors.to_numpy()):
        ax.text(
            column,
            row,
            f"{factor:.2f}",
            ha="center",
            va="center",
            fontsize=7,
            color="black" if factor > 0.5 else "white",
        )
    ax.set_xticks(range(len(factors.columns)), [name.replace(" ", "\n", 1) for name in factors.columns], fontsize=7)
    ax.set_yticks(range(len(factors)), factors.index, fontsize=7)
    return figure


def wedge():
    """One pressure, and the two models that make it: with a wedge pressure, and with a higher resistance."""
    network, mouse, fit = fitted()
    beds = fit.model.outlets
    true = replace(fit.model, outlets=replace(beds, R1=beds.R1 / 2, R2=beds.R2 / 2, C=beds.C * 2), outlet_pressure=8.0)
    made = root_of(true, mouse.inflow)
    recorded = vw.Recording(made.pressure.values, mouse.flow, mouse.period)
    found = {8.0: true.outlets.total_resistance()}
    blind = vw.calibrate(network, recorded, "linear", starts=1)
    found[0.0] = blind.model.outlets.total_resistance()
    figure, ax = plt.subplots(figsize=(4.8, 2.6), layout="constrained")
    time = 1e3 * recorded.time
    ax.plot(
        time, recorded.pressure, color="0.65", lw=4, label=f"8 mmHg behind the beds, R_T {found[8.0]:.0f} mmHg s/ml"
    )
    ax.plot(time, root_of(blind.model, mouse.inflow).pressure, "--", color="black",
            label=f"fitted without it, R_T {found[0.0]:.0f} mmHg s/ml")  # fmt: skip
    ax.set(xlabel="time [ms]", ylabel="pressure in the root [mmHg]", ylim=(None, 1.25 * recorded.pressure.max()))
    label(ax)
    return figure


def trees():
    """What each field of a structured tree does to its resistance and to the modulus of its impedance."""
    network, mouse = vw.control_network(), vw.virtual_mouse()
    tree = vw.estimate_nominal(network, mouse, bed=vw.StructuredTree).outlets
    factors = np.geomspace(0.7, 1.4, 9)
    frequency = np.array([0.0, 2 * np.pi / mouse.period])
    nominal = np.abs(tree.impedance(frequency)).mean(1)
    figure, axes = panels(sharey=True)
    for name, look in (("length_ratio", "o-"), ("smallest", "s--"), ("dilation", "^:"), ("stiffness", "x-.")):
        changed = [replace(tree, **{name: getattr(tree, name) * factor}) for factor in factors]
        each = np.array([np.abs(one.impedance(frequency)).mean(1) for one in changed]) / nominal
        for ax, values in zip(axes, each.T, strict=True):
            ax.plot(factors, values, look, color="black", ms=3, lw=1, label=name)
    axes[0].set(ylabel="over that of the nominal tree [1]", title="resistance", yscale="log")
    axes[1].set(title="|Z| at the heart's frequency")
    for ax in axes:
        ax.set(xlabel="factor of the field [1]", xscale="log")
        ax.set_xticks([0.7, 1, 1.4], ["0.7", "1", "1.4"])
        ax.set_yticks([0.25, 0.5, 1, 2, 4], ["0.25", "0.5", "1", "2", "4"])
        ax.minorticks_off()
    label(axes[1])
    return figure


def friction():
    """Friction by radius, and the mean pressure from root to terminals with either radius."""
    _, mouse, fit = fitted()
    radius = np.linspace(0.008, 0.05, 100)
    delta = np.sqrt(vw.Blood().viscosity * mouse.period / (2 * np.pi))
    figure, axes = panels()
    blood = vw.Blood(friction=vw.BoundaryLayer(reference_radius=0.07))
    for model, dash, one, name in (
        (replace(fit.model, blood=blood), "--", np.full(100, 0.07), "radius 0.07 cm everywhere"),
        (fit.model, "-", radius, "local radius"),
    ):
        axes[0].plot(radius, 2 * one / delta, dash, color="black", label=name)
        root = root_of(model, mouse)
        axes[1].plot(1e3 * root.time, root.pressure, dash, color="black")
    axes[0].set(xlabel="radius [cm]", ylabel="2r/δ [1]", ylim=(0, 6))
    axes[1].set(xlabel="time [ms]", ylabel="pressure in the root [mmHg]")
    label(axes[0])
    return figure


def periodic():
    """How far the mean pressure at the root is from its periodic value, cycle by cycle."""
    _, mouse, fit = fitted()
    cycles = np.arange(1, 15)
    mean = [float(root_of(fit.model, mouse, cycles_from_rest=int(count)).pressure.mean()) for count in cycles]
    end = float(root_of(fit.model, mouse, tolerance=1e-6).pressure.mean())
    figure, ax = plt.subplots(figsize=(4.8, 2.4), layout="constrained")
    ax.plot(cycles, np.abs(end - np.array(mean)), "o-", color="black", ms=3)
    ax.axvline(8, color="0.6", ls=":", zorder=0)
    ax.text(8.1, 3, "compared by the paper", fontsize=7)
    ax.set(
        xlabel="cycle from rest", ylabel="mean pressure short of\nthe periodic one [mmHg]", yscale="log", xticks=cycles
    )
    return figure


def apart():
    """The forward intensity of one recording by area and wave speed at mean pressure, and by those of the paper."""
    _, mouse, fit = fitted()
    at = operating_point(fit.model, float(np.mean(mouse.pressure)))
    area, inertia = np.pi * fit.model.network.radius[0] ** 2, fit.model.blood.inertia
    slower = at.wave_speed * area / at.area  # of the same characteristic impedance
    figure, ax = plt.subplots(figsize=(4.8, 2.6), layout="constrained")
    places = (("at mean pressure", "-", at.area, at.wave_speed), ("A0, as in the paper", "--", area, slower))
    for name, dash, place, speed in places:
        known_there = {"area": place, "wave_speed": speed, "inertia": inertia}
        both = vw.wave_intensity(mouse.pressure, mouse.flow, mouse.period, **known_there)
        ax.plot(1e3 * mouse.time, 1e-3 * both.forward_intensity, dash, color="black", label=f"{name}: {speed:.0f} cm/s")
    ax.set(xlabel="time [ms]", ylabel="forward intensity [kW/(cm² s²)]")
    label(ax)
    return figure


def touching():
    """A tangent wall, and the linear one that stands for it in openBF."""
    wall, mean = vw.TangentWall(15.0, 2.0), 14.0
    pressure = np.linspace(4, 30, 100)
    area, step = vw.walls.area(wall, mean, 1.0), 1e-3
    slope = 2 * step / (vw.walls.area(wall, mean + step, 1.0) - vw.walls.area(wall, mean - step, 1.0))
    beta = 2 * area * slope - mean
    linear = LinearWall(beta)
    rest = area / vw.walls.area(linear, mean, 1.0)
    figure, axes = panels()
    for one, a0, dash, name in ((wall, 1.0, "-", "tangent"), (linear, rest, "--", "linear, as openBF has it")):
        axes[0].plot(vw.walls.area(one, pressure, a0), pressure, dash, color="black", label=name)
        axes[1].plot(pressure, vw.walls.wave_speed(one, pressure, vw.Blood().inertia), dash, color="black")
    axes[0].plot(area, mean, "o", color="black", ms=4)
    axes[1].plot(mean, vw.walls.wave_speed(wall, mean, vw.Blood().inertia), "o", color="black", ms=4)
    axes[0].set(xlabel="area over that at zero pressure [1]", ylabel="pressure [mmHg]")
    axes[1].set(xlabel="pressure [mmHg]", ylabel="wave speed [cm/s]")
    label(axes[0])
    return figure


def loop():
    """The circle of six vessels that the page prints, as the report draws it."""
    edges = [[0, 1], [1, 2], [1, 3], [2, 3], [2, 4], [3, 5]]
    names = ("main", "left", "right", "bridge", "lung 1", "lung 2")
    lengths, radii = [0.41, 0.45, 0.37, 0.20, 0.18, 0.24], [0.047, 0.026, 0.037, 0.015, 0.020, 0.025]
    figure, ax = plt.subplots(figsize=(4.6, 2.8), layout="constrained")
    vw.Network(names, None, lengths, radii, nodes=edges).plot(ax)
    return figure


def draws():
    """Draws of posterior and prior: resistance and wave speed, share a and compliance of the beds."""
    found = known().data
    figure, axes = panels()
    names = {
        "R_T": "R_T [mmHg s/ml]",
        "wave_speed": "wave speed [cm/s]",
        "a": "share R1/R_T [1]",
        "C_p": "C_p [µl/mmHg]",
    }
    ticks = {"R_T": (30, 100, 300), "wave_speed": (100, 200, 400), "a": (0.01, 0.1, 1), "C_p": (0.1, 1, 10)}
    for ax, (one, other) in zip(axes, (("R_T", "wave_speed"), ("a", "C_p")), strict=True):
        for group, color, size in (("prior", "0.75", 3), ("posterior", BLUE, 3)):
            x, y = (found[group][name].values.ravel() * (1e3 if name == "C_p" else 1) for name in (one, other))
            ax.plot(x, y, "." if group == "posterior" else "x", color=color, ms=size, label=group)
        ax.set(xlabel=names[one], ylabel=names[other], xscale="log", yscale="log")
        for axis, name in ((ax.xaxis, one), (ax.yaxis, other)):
            axis.set_ticks(ticks[name], [f"{tick:g}" for tick in ticks[name]])
        ax.minorticks_off()
    label(axes[0])
    return figure


def replicated():
    """The recorded pressure, and what another recording of this animal would show."""
    _, mouse, _ = fitted()
    found = known().data["posterior_predictive"]
    figure, axes = panels()
    for ax, name, title in zip(
        axes, ("simulated", "pressure"), ("the model alone", "with discrepancy and errors"), strict=True
    ):
        values = found[name]
        every = values.values.reshape(-1, values.shape[-1])
        time = 1e3 * mouse.period * np.arange(every.shape[1]) / every.shape[1]
        low, high = np.percentile(every, [2.5, 97.5], axis=0)
        ax.fill_between(time, low, high, color=BLUE, alpha=0.35, lw=0, label="95 % of draws")
        ax.plot(1e3 * mouse.time, mouse.pressure, color="black", lw=1, label="recorded")
        ax.set(xlabel="time [ms]", ylabel="pressure [mmHg]", title=title)
    label(axes[0])
    return figure


def shared():
    """Half width of a ratio's interval by animals a group, with an image for each and with one for a group."""
    animals = np.arange(3, 31)
    spread, image = 0.25, 0.10
    figure, ax = plt.subplots(figsize=(4.8, 2.6), layout="constrained")
    for name, dash, error in (
        ("an image for each animal", "-", np.sqrt(2 * (spread**2 + image**2) / animals)),
        ("one image for each group", "--", np.sqrt(2 * (spread**2 / animals + image**2))),
    ):
        half = student.ppf(0.975, 2 * animals - 2) * error
        ax.plot(animals, 100 * np.expm1(half), dash, color="black", label=name)
    ax.set(xlabel="animals of each group", ylabel="ratio shown at 5 % [% more]", ylim=(0, 120))
    label(ax)
    return figure


def pairs():
    """Power by number: two groups, and pairs whose true values are correlated by a half."""
    figure, axes = panels(sharey=True)
    for ax, correlated, title in ((axes[0], {}, "two groups"), (axes[1], {"pairs": 0.5}, "pairs")):
        powers = vw.plan(effect=1.5, **correlated).powers
        for name, look in (("mPAP", "o-"), ("R_T", "s--"), ("stiffness", "^-."), ("a", "x:")):
            ax.plot(powers.index, powers[name], look, color="black", ms=3, lw=1, label=name)
        ax.axhline(0.8, color="0.7", zorder=0)
        ax.set(
            title=title, xlabel=f"{powers.index.name} (of each group)" if not correlated else "pairs", ylim=(0, 1.02)
        )
    axes[0].set(ylabel="ratio of 1.5 is shown [1]")
    label(axes[1], loc="lower right")
    return figure


def harmonics():
    """Harmonics of a practice recording, their errors and the residual of a fit."""
    average = vw.read_raw_recording("lab/control/mouse 1.txt").average()
    errors = harmonic_errors(average)
    fit = vw.calibrate(vw.read_network("lab/lung control.csv"), average, "linear", starts=1)
    figure, ax = plt.subplots(figsize=(5.6, 2.6), layout="constrained")
    count = np.arange(1, len(errors.modulus))
    ax.plot(count, errors.modulus[1:], "o-", color="black", ms=3, label="measured")
    ax.plot(count, errors.error[1:], "x:", color="black", ms=3, label="standard error")
    left = fit.harmonics["residual_modulus"].to_numpy()[1:]
    ax.plot(np.arange(1, len(left) + 1), np.abs(left), "s--", color=BLUE, ms=3, label="residual of the fit")
    ax.axvline(errors.with_signal + 0.5, color="0.6")
    ax.set(xlabel="harmonic of the pressure", ylabel="modulus [mmHg]", yscale="log", xlim=(0, 21), ylim=(1e-3, None))
    ax.set_xticks(range(0, 21, 5))
    label(ax)
    return figure


def correlated():
    """How the residual of a fit is correlated with itself."""
    _, _, fit = fitted()
    figure, ax = plt.subplots(figsize=(4.8, 2.4), layout="constrained")
    fit.plot.autocorrelation(ax)
    return figure


def viscous():
    """Pressure against area, elastic and viscous, and the pressures over time."""
    _, mouse, fit = fitted()
    figure, axes = panels()
    for eta, dash in ((0.0, "-"), (0.5, "--")):
        waves = root_of(fit.model.changed(wall_viscosity=eta), mouse)
        axes[0].plot(1e2 * waves.area, waves.pressure, dash, color="black", lw=1, label=f"η = {eta:g} mmHg s")
        axes[1].plot(1e3 * waves.time, waves.pressure, dash, color="black", lw=1)
    axes[0].set(xlabel="area of the root [mm²]", ylabel="pressure [mmHg]")
    axes[1].set(xlabel="time [ms]", ylabel="pressure [mmHg]")
    label(axes[0])
    return figure


def anchored():
    """One law with the radii of the image taken at 0 and at 6.3 mmHg."""
    pressure = np.linspace(0, 30, 100)
    figure, axes = panels()
    for image, dash in ((0.0, "--"), (6.3, "-")):
        wall = vw.TangentWall(15.0, 2.0)
        rest = 1.0 / vw.walls.area(wall, image, 1.0)
        axes[0].plot(
            pressure, np.sqrt(vw.walls.area(wall, pressure, rest)), dash, color="black", label=f"at {image:g} mmHg"
        )
        axes[0].plot(image, 1.0, "o", color="black", ms=4)
        axes[1].plot(pressure, vw.walls.area_compliance(wall, pressure, rest), dash, color="black")
    axes[0].set(xlabel="pressure [mmHg]", ylabel="radius over that of the image [1]")
    axes[1].set(xlabel="pressure [mmHg]", ylabel="dA/dp over area [1/mmHg]", ylim=(0, None))
    label(axes[0], title="image taken", title_fontsize=7)
    return figure


def ringing():
    """What a catheter that rings makes of a pressure, and its response."""
    mouse = vw.virtual_mouse()
    catheter = Catheter(45.0, 0.2)
    rate = np.fft.rfftfreq(len(mouse.pressure), mouse.period / len(mouse.pressure))
    seen = np.fft.irfft(np.fft.rfft(mouse.pressure) * catheter.response(rate), len(mouse.pressure))
    frequency = np.linspace(0, 120, 200)
    figure, axes = panels()
    axes[0].plot(
        1e3 * mouse.time, mouse.pressure, color="black", label=f"true, pulse {np.ptp(mouse.pressure):.1f} mmHg"
    )
    axes[0].plot(1e3 * mouse.time, seen, "--", color="black", label=f"recorded, pulse {np.ptp(seen):.1f} mmHg")
    axes[1].plot(frequency, np.abs(catheter.response(frequency)), color="black")
    axes[1].plot(rate[1:9], np.abs(catheter.response(rate[1:9])), "o", color="black", ms=3, label="harmonics 1 to 8")
    axes[0].set(xlabel="time [ms]", ylabel="pressure [mmHg]", ylim=(None, 1.25 * seen.max()))
    axes[1].set(xlabel="frequency [Hz]", ylabel="recorded over true [1]", ylim=(0, None))
    for ax in axes:
        label(ax)
    return figure


def stretch():
    """What is averaged of a recording whose catheter wedges after six of twelve seconds."""
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=12.0).raw
    wedged = np.where(raw.time < 6.0, raw.pressure, 8.0 + 0.03 * (raw.pressure - raw.pressure.mean()))
    with warnings.catch_warnings(record=True):
        cut = vw.average_beats(replace(raw, pressure=wedged)).beats
    used = (raw.time >= cut[0].start) & (raw.time <= cut[-1].end)
    figure, ax = panels(1)
    ax.plot(raw.time, wedged, color="0.6", lw=0.6, label="recorded")
    ax.plot(raw.time[used], wedged[used], color="black", lw=0.6, label="cut into beats")
    ax.set(xlabel="time [s]", ylabel="pressure [mmHg]", xlim=(0, 12))
    label(ax, loc="upper right")
    return figure


def way():
    """Which command reads and writes what in a study."""
    figure, ax = plt.subplots(figsize=(6.9, 2.2))
    ax.set(xlim=(0, 10), ylim=(0, 3), position=(0, 0, 1, 1))
    ax.axis("off")
    boxes = {
        "yours": (0.9, 1.5, "recordings\nvessel tables"),
        "table": (3.4, 2.2, "animals.csv\none row an animal"),
        "settings": (3.4, 0.8, "study.yaml\nsettings"),
        "results": (6.4, 1.5, "results/\none file an animal"),
        "report": (9.0, 1.5, "report/\npages, tables,\nfigures"),
    }
    for x, y, text in boxes.values():
        ax.text(x, y, text, ha="center", va="center", fontsize=8.5, bbox={"fc": "white", "ec": "black", "pad": 5})
    for start, end, text, place in (
        ((1.65, 1.65), (2.5, 2.1), "add", (1.95, 2.15)),
        ((4.35, 2.1), (5.55, 1.6), "run", (5.05, 2.1)),
        ((4.05, 0.85), (5.55, 1.4), "", (0, 0)),
        ((7.3, 1.5), (8.3, 1.5), "report", (7.8, 1.65)),
    ):
        ax.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": "black"})
        ax.text(*place, text, ha="center", fontsize=9, color=BLUE, weight="bold")
    ax.text(1.0, 0.72, "new", ha="center", va="center", fontsize=9, color=BLUE, weight="bold")
    ax.annotate("", (2.75, 0.8), (1.35, 0.74), arrowprops={"arrowstyle": "->", "color": "black"})
    ax.text(3.4, 1.5, "check", ha="center", va="center", fontsize=9, color=BLUE, weight="bold")
    for y in (1.85, 1.18):
        ax.annotate("", (3.4, y), (3.4, 1.62 if y > 1.5 else 1.38), arrowprops={"arrowstyle": "->", "color": "black"})
    return figure


if __name__ == "__main__":
    with plt.rc_context(draw.STYLE):
        for name in sys.argv[1:]:
            (globals().get(name) or getattr(draw, name))().savefig(f"{name}.svg")
