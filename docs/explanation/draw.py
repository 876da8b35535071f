"""Draw a figure of these pages, named like a function below, into the working folder as SVG: `python draw.py waves`."""

import sys
from functools import cache

import matplotlib.pyplot as plt
import numpy as np

import vasowave as vw
from vasowave.pulse.analysis import operating_point

STYLE = {"font.size": 9, "svg.fonttype": "none", "axes.spines.top": False, "axes.spines.right": False}


@cache
def fitted():
    """Return a synthetic mouse, its network and the fit of the linear wall."""
    network, mouse = vw.control_network(), vw.virtual_mouse()
    return network, mouse, vw.calibrate(network, mouse, "linear", starts=1)


@cache
def known():
    """Return the posterior of that mouse."""
    network, mouse, fit = fitted()
    return vw.posterior(network, mouse, "linear", fit=fit)


def waves():
    """One pulse on its way: pressure and flow at the middle of the vessels from the root to an end."""
    _, mouse, fit = fitted()
    simulated = vw.simulate(fit.model, mouse)
    path = ["1", "3", "6", "14", "18", "20"]
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 2.8), layout="constrained")
    for name, shade in zip(path, np.linspace(0.0, 0.7, len(path)), strict=True):
        one = simulated.sel(vessel=name, station="middle")
        axes[0].plot(1e3 * one.time, one.pressure, color=str(shade), label=f"vessel {name}")
        axes[1].plot(1e3 * one.time, one.flow, color=str(shade))
    axes[0].set(xlabel="time [ms]", ylabel="pressure [mmHg]")
    axes[1].set(xlabel="time [ms]", ylabel="flow [ml/s]")
    axes[0].legend(frameon=False, fontsize=7)
    return figure


def taper():
    """The same tree straight and tapering, with the pressure that nothing but the taper changes."""
    network, mouse, fit = fitted()
    figure, ax = plt.subplots(figsize=(4.6, 2.8), layout="constrained")
    for percent, dash in ((0, "-"), (10, "--"), (20, ":")):
        shape = vw.Shape([1 + percent / 200, 1 - percent / 200]) if percent else None
        model = vw.Model(network, fit.model.wall, fit.model.outlets, fit.model.blood, shape=shape, junctions="total")
        root = vw.simulate(model, mouse).pressure.sel(vessel="1", station="inlet")
        ax.plot(
            1e3 * root.time,
            root,
            dash,
            color="black",
            label=f"{percent} % narrower at the end, mean {root.mean():.1f} mmHg",
        )
    ax.set(xlabel="time [ms]", ylabel="pressure in the root [mmHg]")
    ax.legend(frameon=False, fontsize=7)
    return figure


def intervals():
    """What one recording says of one mouse: interval of the fit, of the posterior, and of the prior alone."""
    posterior, own = known().summary, fitted()[2].summary()
    names = {"wave_speed": "wave speed", "R_T": "resistance R_T", "C_p": "compliance of the beds", "a": "share R1/R_T"}
    figure, ax = plt.subplots(figsize=(5.6, 2.6), layout="constrained")
    for row, name in enumerate(names):
        one, fits = posterior.loc[name], own.loc[name]
        for place, (low, high), width, color in (
            (-0.25, (one["prior_low"], one["prior_high"]), 6, "0.85"),
            (0.0, (one["interval_low"], one["interval_high"]), 4, "#0072b2"),
            (0.25, (fits["low"], fits["high"]), 2, "black"),
        ):
            ax.plot(
                np.array([low, high]) / fits["value"], [row + place] * 2, lw=width, color=color, solid_capstyle="butt"
            )
    ax.set(xlabel="value over that of the fit [1]", xscale="log", xlim=(0.3, 3.3), ylim=(3.6, -1.5), yticks=range(4))
    ax.set_yticklabels(names.values())
    ax.set_xticks([0.3, 0.5, 1, 2, 3], ["0.3", "0.5", "1", "2", "3"])
    ax.minorticks_off()
    for color, label in (("0.85", "prior"), ("#0072b2", "posterior"), ("black", "fit alone")):
        ax.plot([], [], color=color, lw=4, label=label)
    ax.legend(frameon=False, ncols=3, loc="upper left", fontsize=7)
    return figure


def sites():
    """Flow in a branch as a second site: observed, fitted and predicted; and what it adds."""
    network, mouse, fit = fitted()
    rng, branch = np.random.default_rng(3), fit.simulation.sel(vessel="2", station="middle").flow.values
    flow = (
        branch + 0.02 * np.ptp(branch) * np.sin(np.arange(len(branch)) / 9) + 0.003 * rng.standard_normal(len(branch))
    )
    pressure = fit.simulation.sel(vessel="1", station="inlet").pressure.values
    noisy = pressure + 0.15 * np.sin(np.arange(len(pressure)) / 11) + 0.1 * rng.standard_normal(len(pressure))
    cycle = vw.Recording(noisy, mouse.flow, mouse.period)
    one = vw.Observation("flow", "2", error=0.003, waveform=flow)
    both = vw.calibrate(network, cycle, "linear", starts=1, sites=[one]).sites.isel(site=0)
    figure, axes = plt.subplots(1, 2, figsize=(6.9, 2.6), layout="constrained", width_ratios=(3, 2))
    for name, look in (("measured", {"color": "black"}), ("predicted", {"color": "0.6", "lw": 3, "zorder": 0}),
                       ("simulated", {"color": "#0072b2", "ls": "--"})):  # fmt: skip
        axes[0].plot(1e3 * both.time, both[name], label=name.replace("measured", "observed"), **look)
    axes[0].set(xlabel="time [ms]", ylabel="flow in vessel 2 [ml/s]")
    axes[0].legend(frameon=False, fontsize=7)
    truth = fit.summary()["value"]
    for row, name in enumerate(("wave_speed", "R_T")):
        here = both.sel(quantity=name)
        for place, end, color in ((-0.12, "_without", "0.6"), (0.12, "", "black")):
            ends = np.array([float(here[f"{side}{end}"]) for side in ("low", "high")])
            axes[1].plot(ends / truth[name], [row + place] * 2, color=color, lw=4, solid_capstyle="butt")
    axes[1].axvline(1.0, color="0.85", zorder=0)
    axes[1].set(xlabel="value over the true one [1]", ylim=(1.5, -0.5), yticks=(0, 1))
    axes[1].set_yticklabels(("wave speed", "resistance R_T"))
    return figure


def drift():
    """The practice recording whose baseline moves while pulse and flow stay."""
    raw = vw.read_raw_recording("lab/hypoxia/mouse 2.txt")
    figure, axes = plt.subplots(2, 1, figsize=(6.9, 3.2), sharex=True, layout="constrained")
    for ax, values, label in zip(axes, (raw.pressure, raw.flow), ("pressure [mmHg]", "flow [ml/s]"), strict=True):
        ax.plot(np.arange(len(values)) / raw.sampling_rate, values, color="black", lw=0.5)
        ax.set(ylabel=label)
    axes[1].set(xlabel="time [s]")
    return figure


def beats():
    """Two seconds of a practice recording, and the cycle averaged from it with its scatter."""
    raw = vw.read_raw_recording("lab/control/mouse 1.txt")
    figure = plt.figure(figsize=(6.9, 3.8), layout="constrained")
    signals, cycle = figure.subfigures(1, 2, width_ratios=(2, 1))
    raw.plot(slice(2, 4), signals.subplots(3, 1, sharex=True))
    raw.average().plot(cycle.subplots(2, 1, sharex=True))
    signals.align_ylabels()
    cycle.align_ylabels()
    return figure


def power():
    """How often an effect is shown, by the number of animals."""
    return vw.plan(effect=1.5).figure()


def network():
    """The control network as a notebook draws it, and the fit of a synthetic mouse to it."""
    vessels, _, fit = fitted()
    figure, axes = plt.subplots(1, 2, figsize=(6.9, 3.0), layout="constrained")
    vessels.plot(axes[0])
    fit.plot.pressure(axes[1])
    return figure


def walls():
    """The three laws that have the same radius and stiffness at zero pressure, and their wave speeds."""
    laws = {
        "linear": (vw.LinearWall(60.0), "--"),
        "tangent": (vw.TangentWall(60.0 * 2.0 / np.pi / 2.0, 2.0), "-"),
        "power, m = 3": (vw.PowerWall(60.0, 3.0), ":"),
    }
    pressure = np.linspace(0.0, 60.0, 200)
    figure, axes = plt.subplots(1, 2, figsize=(6.9, 2.8), layout="constrained")
    for name, (wall, dash) in laws.items():
        area = vw.walls.area(wall, pressure, 1.0)
        axes[0].plot(np.sqrt(area), pressure, dash, color="black", label=name)
        speed = vw.walls.wave_speed(wall, pressure, vw.Blood().inertia)
        axes[1].plot(pressure, speed, dash, color="black")
    axes[0].set(xlabel="radius over that at zero pressure [1]", ylabel="pressure [mmHg]")
    axes[1].set(xlabel="pressure [mmHg]", ylabel="wave speed [cm/s]")
    axes[0].legend(frameon=False, fontsize=7)
    return figure


def beds():
    """Impedance of a terminal's bed: Windkessel, structured tree and bare resistance of the same resistance."""
    network, mouse = vw.control_network(), vw.virtual_mouse()
    harmonics = np.arange(0, 13)
    figure, axes = plt.subplots(1, 2, figsize=(6.9, 2.6), layout="constrained")
    for name, kind, dash in (("Windkessel", vw.Windkessel, "o-"), ("structured tree", vw.StructuredTree, "s--"),
                             ("resistance", vw.Resistance, "x:")):  # fmt: skip
        bed = vw.estimate_nominal(network, mouse, bed=kind).outlets
        Z = bed.impedance(2 * np.pi * harmonics / mouse.period)[:, 0]
        axes[0].plot(harmonics, np.abs(Z), dash, color="black", ms=3, label=name)
        axes[1].plot(harmonics, np.angle(Z, deg=True), dash, color="black", ms=3)
    axes[0].set(xlabel="harmonic", ylabel="|Z| [mmHg s/ml]", ylim=(0, None), xticks=range(0, 13, 2))
    axes[1].set(xlabel="harmonic", ylabel="phase [°]", xticks=range(0, 13, 2))
    axes[0].legend(frameon=False, fontsize=7)
    return figure


def separated():
    """A pressure taken apart into what runs from the heart and what comes back, and their wave intensities."""
    _, mouse, fit = fitted()
    at = operating_point(fit.model, float(np.mean(mouse.pressure)))
    known = {"area": at.area, "wave_speed": at.wave_speed, "inertia": fit.model.blood.inertia}
    waves = vw.wave_intensity(mouse.pressure, mouse.flow, mouse.period, **known)
    time = 1e3 * mouse.time
    figure, axes = plt.subplots(1, 2, figsize=(6.9, 2.6), layout="constrained")
    for values, dash, label in ((mouse.pressure - mouse.pressure[0], "-", "p − p(0)"),
                                (waves.forward_pressure - waves.forward_pressure[0], "--", "forward"),
                                (waves.backward_pressure - waves.backward_pressure[0], ":", "backward")):  # fmt: skip
        axes[0].plot(time, values, dash, color="black", label=label)
    axes[1].plot(time, 1e-3 * waves.forward_intensity, "--", color="black")
    axes[1].plot(time, 1e-3 * waves.backward_intensity, ":", color="black")
    axes[0].set(xlabel="time [ms]", ylabel="pressure [mmHg]")
    axes[1].set(xlabel="time [ms]", ylabel="wave intensity [kW/(cm² s²)]")
    axes[0].legend(frameon=False, fontsize=7)
    return figure


def shares():
    """Where the width of four intervals comes from."""
    summary = known().summary
    names = {"wave_speed": "wave speed", "R_T": "resistance R_T", "C_p": "compliance of the beds", "a": "share R1/R_T"}
    sources = ("recording", "probe", "calibration", "image", "model", "prior")
    figure, ax = plt.subplots(figsize=(6.2, 2.4), layout="constrained")
    left = np.zeros(len(names))
    for source, shade, hatch in zip(sources, np.linspace(0.15, 0.95, 6), ("", "///", "", "...", "", "xx"), strict=True):
        part = summary.loc[list(names), source].to_numpy()
        ax.barh(list(names.values()), part, left=left, color=str(shade), edgecolor="black", hatch=hatch, label=source)
        left += part
    ax.set(xlabel="share of the variance [1]", xlim=(0, 1))
    ax.invert_yaxis()
    ax.legend(frameon=False, fontsize=7, ncols=6, loc="lower center", bbox_to_anchor=(0.4, 1.0))
    return figure


def residuals():
    """What two laws leave of one pressure."""
    network, mouse, fit = fitted()
    figure, ax = plt.subplots(figsize=(5.6, 2.4), layout="constrained")
    for law, dash in (("linear", "--"), ("tangent", "-")):
        one = fit if law == "linear" else vw.calibrate(network, mouse, law, starts=1)
        left = one.residual
        time = np.linspace(0, 1e3 * mouse.period, len(left), endpoint=False)
        ax.plot(time, left, dash, color="black", label=f"{law}: RMSE {one.rmse:.2f} mmHg")
    ax.set(xlabel="time [ms]", ylabel="measured − simulated [mmHg]", ylim=(-0.6, 0.6))
    ax.legend(frameon=False, fontsize=7, loc="upper right", ncols=2)
    return figure


if __name__ == "__main__":
    with plt.rc_context(STYLE):
        name = sys.argv[1]
        globals()[name]().savefig(f"{name}.svg")
