"""Break the source in known ways, one at a time, and see which test notices.

uv run python benchmarks/planted_faults.py             every fault
uv run python benchmarks/planted_faults.py friction    only those with this word in their name

Every fault is planted in a fresh copy of src/. Exit code 1: a fault survived. Exit code 2: nothing can be concluded,
because a fault does not fit the source, the tests fail without any fault, or they did not run to a verdict.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
KERNELS = ROOT / "build" / "kernels of planted faults"
WORDS = (
    "solver conservation nodes linear order newton inflow steady impedance walls blood trigonometry powers tubes "
    "sensitivity starts kernels unlike_volumes witness discharge junctions changing shape viscous test_problem "
    "test_rounds test_modes straight_trees valleys asks_for_few"
)
LONGEST = 1800  # s for one run of the tests; a fault that makes them hang has no verdict
TESTS = ["tests", "-m", "not validation and not weekly", "-k", " or ".join(WORDS.split())]


class Fault(NamedTuple):
    """A wrong edit: every (old, new) text is replaced in `file`, where old must stand exactly once."""

    name: str
    file: str
    edits: tuple[tuple[str, str], ...]


CELLS, NODES, CYCLE = "pulse/solver/cells.py", "pulse/solver/nodes.py", "pulse/solver/cycle.py"
VARIATIONS, NODE_VARIATIONS = "pulse/solver/variations.py", "pulse/solver/node_variations.py"
BEDS, POWERS = "pulse/solver/beds.py", "pulse/solver/powers.py"
PERIODIC, TUBES = "pulse/solver/periodic.py", "lung/axes/tubes.py"
UNKNOWNS = "pulse/inference/unknowns.py"
STRAIGHT_TREES = "pulse/model/straight_trees.py"
FAULTS = [
    Fault(
        "walls anchored at rest",
        "pulse/model/model.py",
        (("return area / np.asarray(wall.ratio_at(self.network.pressure, *wall))", "return area"),),
    ),
    Fault(
        "friction halved",
        CELLS,
        (("0.5 * cells.dt[j] * drag", "0.25 * cells.dt[j] * drag"),),
    ),
    Fault(
        "friction missing in the first half of the step",
        CELLS,
        (("slowed(0.25 * cells.dt[j - 1]", "slowed(0.0 * cells.dt[j - 1]"),),
    ),
    Fault("friction missing at vessel ends", NODES, (("slowed(0.5 * ends.dt[e]", "slowed(0.0 * ends.dt[e]"),)),
    Fault(
        "boundary layer as the paper misprints it",
        "pulse/model/blood.py",
        (("math.sqrt(viscosity * period / (2 * math.pi))", "math.sqrt(2 * math.pi * viscosity / period)"),),
    ),
    Fault("drag as an explicit step", CELLS, (("E = 1.0 / (1.0 + x + 0.5 * x * x)", "E = 1.0 - x"),)),
    Fault("thin vessels on two cells", "pulse/solver/grid.py", (("_STEADY_ERROR = 2e-4", "_STEADY_ERROR = 2e4"),)),
    Fault(
        "solver's vessels of one cell without a slope",
        CYCLE,
        (("            continue_lines(area, flow, vessels.single, faces)\n", ""),),
    ),
    Fault(
        "solver's vessels of one cell slope the wrong way",
        CELLS,
        (("area[j] + rise, area[j] - rise", "area[j] - rise, area[j] + rise"),),
    ),
    Fault("one cell where the pressure falls", "pulse/solver/grid.py", (("_FLAT = 0.05", "_FLAT = 5.0"),)),
    Fault(
        "sensitivity of vessels of one cell without a slope",
        "pulse/solver/varied_cycle.py",
        (("continue_lines(dA[d], dq[d],", "continue_lines(0.0 * dA[d], dq[d],"),),
    ),
    Fault(
        "linear network about rest",
        "pulse/model/two_ports.py",
        (
            (
                "return np.asarray(without) + 0.5 * (1.0 + share_passed) * above",
                "return np.asarray(without) + 0.0 * share_passed",
            ),
        ),
    ),
    Fault("flow faster than its waves", "pulse/solver/validity.py", (("mach.value >= 1.0", "mach.value >= 1e9"),)),
    Fault("drag bends no pressure", "pulse/solver/grid_error.py", (("**2 / 8 * drag", "**2 / 80 * drag"),)),
    Fault("fronts between two kept steps", "pulse/model/numerics.py", (("_FRONT = 4 ", "_FRONT = 16 "),)),
    Fault("fronts between two times", "pulse/solver/grid_error.py", (("_FRONT = 2.0", "_FRONT = 10.0"),)),
    Fault(
        "echoes that no one counts",
        "pulse/solver/grid_error.py",
        (("max(1.0, 2.0 / (math.e", "max(1.0, 0.0 / (math.e"),),
    ),
    Fault("fronts steeper than cells carry", "pulse/solver/grid_error.py", (("_FRONT = 2.0", "_FRONT = 0.0"),)),
    Fault("dispersion a tenth of what it is", "pulse/solver/grid_error.py", (("/ (6 * c**3)", "/ (60 * c**3)"),)),
    Fault(
        "solver's accuracy of the first pair of grids",
        "pulse/solver/accuracy.py",
        (("if error <= accuracy", "if error"),),
    ),
    Fault(
        "discharge of vessels alone",
        "pulse/solver/discharge.py",
        (("(-beds.poles.real * period < _GONE) & (beds", "(beds.poles.real > 0) & (beds"),),
    ),
    Fault(
        "discharge into nothing",
        "pulse/solver/relaxation.py",
        (("weight / (z + modes.softness * adm", "weight / (z + 2 * modes.softness * adm"),),
    ),
    Fault("discharge not awaited", PERIODIC, ((" + to_come(change - weights @ combined[0])", ""),)),
    Fault(
        "solver's samples are those of steps",
        "pulse/solver/result.py",
        (("= resample(signal[window], samples)", "= signal[window][:samples]"),),
    ),
    Fault(
        "solver takes more steps than allowed",
        "pulse/solver/run.py",
        (("largest = numerics.largest_", "largest = 10 * numerics.largest_"),),
    ),
    Fault("solver never starts from rest", "pulse/solver/run.py", (("except Lost:", "except ZeroDivisionError:"),)),
    Fault(
        "sensitivity without the change of drag",
        VARIATIONS,
        (("stencil.drag[j] = quarter * (", "stencil.drag[j] = 0.0 * ("),),
    ),
    Fault(
        "sensitivity without the change of pressure by the wall's parameters",
        VARIATIONS,
        (("stencil.fall[j] * (slopes.wall[k, j + 1]", "0.0 * (slopes.wall[k, j + 1]"),),
    ),
    Fault(
        "sensitivity without the change of wave speed at vessel ends",
        NODE_VARIATIONS,
        (("by_speed = -side * area_difference * Phi - half * by_reach", "by_speed = 0.0 * area_difference"),),
    ),
    Fault(
        "sensitivity without longer cells",
        VARIATIONS,
        (("stencil.length[j] = -push * force", "stencil.length[j] = 0.0"),),
    ),
    Fault(
        "sensitivity with beds that do not give way",
        NODE_VARIATIONS,
        (("slopes.give[k] += 1.0 / outlet", "slopes.give[k] += 0.0 / outlet"),),
    ),
    Fault(
        "sensitivity without longer vessels at their ends",
        NODE_VARIATIONS,
        (("slopes.length[e] * longer[e]", "0.0 * longer[e]"),),
    ),
    Fault(
        "sensitivity with outlets whose memory does not change",
        NODE_VARIATIONS,
        ((" + outlets.decay[d, j, i] * before[j, i]", ""),),
    ),
    Fault(
        "sensitivity of a cycle that is not periodic",
        PERIODIC,
        (("return output - weights @ current[2]", "return output"),),
    ),
    Fault(
        "simulations do not correct the linear network by their derivatives",
        "pulse/calibration/surrogate.py",
        (("np.vstack([spectrum - base, (slopes - linear_slopes).T])", "np.vstack([spectrum - base, 0.0 * slopes.T])"),),
    ),
    Fault(
        "a response is sought as if nothing were recorded through it",
        "pulse/calibration/response_search.py",
        (("halves = passed * (", "halves = 1.0 * ("),),
    ),
    Fault(
        "places are led out of the bounds",
        "pulse/calibration/descent.py",
        (("np.clip(proposed[behind], *bounds)", "proposed[behind]"),),
    ),
    Fault(
        "beds that are no circuits stay the nominal ones",
        "pulse/calibration/linear_tree.py",
        (("np.log(values[:, bed] / nominal)", "0.0 * np.log(values[:, bed] / nominal)"),),
    ),
    Fault(
        "networks with loops are led by no tree",
        "pulse/calibration/linear_tree.py",
        (("if network.nodes is None:", "if len(network):"),),
    ),
    Fault(
        "searches that go on have an old Jacobian",
        "pulse/calibration/optimization.py",
        (("gain < self.tolerance * S and", "gain < 0.5 * S and"),),
    ),
    Fault(
        "solver's kernels with arrays that overlap",
        "pulse/solver/stepper.py",
        (("Faces(np.ones(slots), np.ones(slots))", "Faces(*[np.ones(slots)] * 2)"),),
    ),
    Fault(
        "a solver's tube that should merge",
        "pulse/solver/failures.py",
        (("if len(grid.counts) > 1:", "if len(grid.counts) > 0:"),),
    ),
    Fault("kernels of any source", "base/runtime/kernels.py", (("cache_tag, sources)", "cache_tag)"),)),
    Fault("kernels of the wheel on any processor", "base/runtime/shipped.py", (("names >= _INSTRUCTIONS", "True"),)),
    Fault("kernels are compiled by everyone", "base/runtime/kernels.py", (("self._lock = _waited_for(", "_ = ("),)),
    Fault("convective term dropped", CELLS, (("fluxes.momentum[j] = q * q * per_area", "fluxes.momentum[j] = 0.0"),)),
    Fault("one Newton step", NODES, (("NEWTON_CLOSE = 1e-", "NEWTON_CLOSE = 1e+"),)),
    Fault("inflow late by a step", CYCLE, (("solve_nodes(inflow[n],", "solve_nodes(inflow[n - 1],"),)),
    Fault(
        "junction adds a daughter's flow",
        NODES,
        (("+= ends.side[e] * nodes.intercept[e] + m *", "+= nodes.intercept[e] + nodes.slope[e] *"),),
    ),
    Fault(
        "characteristics start at the cell's center",
        NODES,
        (("reach = 0.5 - side * (u + side * c) * half", "reach = 0.0"),),
    ),
    Fault("half step of area halved", CELLS, (("A - half * (flow[j]", "A - 0.5 * half * (flow[j]"),)),
    Fault("tangent one term short", POWERS, (("13860.0 + w * 45.0", "13860.0"),)),
    Fault("arctangent one term short", POWERS, (("P = 46107386325.0 + w * 2015310375.0", "P = 46107386325.0"),)),
    Fault("logarithm one term short", POWERS, (("1 / 17 + w * (1 / 19)", "1 / 17"),)),
    Fault("exponential one term short", POWERS, (("1 / 39916800 + r * (1 / 479001600)", "1 / 39916800"),)),
    Fault("a power that is too large wraps around", POWERS, (("np.minimum(np.maximum(y, -_MOST), _MOST)", "y + 0.0"),)),
    Fault("R1 dropped", BEDS, (("beds.direct + gain", "0 * beds.direct + gain"),)),
    Fault("nothing lies behind the beds", BEDS, (("= bed.behind[j]", "= 0.0 * bed.behind[j]"),)),
    Fault("capacitor discharges a whole step early", BEDS, (("bed.decay_half[j, i]", "bed.decay[j, i]"),)),
    Fault(
        "capacitor not charged between steps",
        BEDS,
        (("beds.direct + gain_half.real", "beds.direct + 0 * gain_half.real"),),
    ),
    Fault("tangent wall of constant slope", "pulse/model/walls.py", (("(p1 * p1 + p * p)", "(p1 * p1)"),)),
    Fault("tubes' free ends slide along their axes", TUBES, (("along * np.sqrt(DENSITY)", "along * 0.0"),)),
    Fault(
        "tubes are as stiff with a wall as without",
        TUBES,
        (("FREE_WEIGHT, HIDDEN_WEIGHT = 0.35", "FREE_WEIGHT, HIDDEN_WEIGHT = 64.0"),),
    ),
    Fault(
        "a thin vessel's own contrast is believed",
        "lung/measure/contrast.py",
        (("UNKNOWN_BLUR_SHARE = 1.0", "UNKNOWN_BLUR_SHARE = 0.0"),),
    ),
    Fault("every vessel has the contrast of the tree", "lung/measure/contrast.py", (("prior = 1 /", "prior = 1e9 /"),)),
    Fault(
        "a frame of zeros is background",
        "lung/lumen/levels.py",
        (("real |= grey[np.ix_(*neighbors)] != sample", "real |= True"),),
    ),
    Fault("resampled cubes drift", "lung/read/volume.py", (("step = smallest", "step = 1.002 * smallest"),)),
    Fault("the second witness overlooks ends", "lung/witness/topology.py", (("if spare and all_ends", "if False"),)),
    Fault("tubes follow every bump", TUBES, (("OUTLIER, SHAPE = 0.5", "OUTLIER, SHAPE = 500.0"),)),
    Fault(
        "tubes' sections count their neighbors",
        "lung/measure/profiles.py",
        (("foreign |= in_tube(", "foreign &= in_tube("),),
    ),
    Fault("ovals have rims", "lung/measure/profiles.py", (("OVAL * mean[0] ** 2", "0 * mean[0] ** 2"),)),
    Fault("a line takes no samples", "lung/measure/evening.py", (("max(samples - 2, MIN_FREEDOM)", "samples"),)),
    Fault(
        "tubes' radii count within sisters",
        "lung/measure/measurement.py",
        (
            (
                "enumerate(zip(tree.lines, clear_stretches(tree), strict=True))",
                "enumerate(zip(tree.lines, free_stretches(tree), strict=True))",
            ),
            ("clear_stretches, free_length\n", "clear_stretches, free_length, free_stretches\n"),
        ),
    ),
    Fault(
        "measured tapers turned round",
        "pulse/model/shape.py",
        (("(fall, [0.5, -0.5])", "(fall, [-0.5, 0.5])"),),
    ),
    Fault(
        "areas averaged where vessels change",
        "pulse/solver/changing.py",
        (("for j in changing.face:", "for j in changing.face[:0]:"),),
    ),
    Fault("no push of viscous walls", "pulse/solver/viscosity.py", (("flow[j] -= push *", "flow[j] -= 0.0 * push *"),)),
    Fault(
        "viscous walls hear nothing of the ends",
        "pulse/solver/viscosity.py",
        (("inlet_diagonal, coupled, before = kappa[first], kappa", "inlet_diagonal, coupled, before = 0.0, kappa"),),
    ),
    Fault(
        "viscous walls as at the whole step",
        "pulse/solver/viscosity.py",
        (("area[j] - cells.half[j] * (flow", "area[j] - 0.0 * (flow"),),
    ),
    Fault(
        "viscosity without derivative",
        "pulse/solver/viscosity.py",
        (("changed.viscosity[d, j] - longer[j]", "-longer[j]"),),
    ),
    Fault(
        "tied pressures without fill",
        "pulse/solver/elimination.py",
        (("entries[joints.fill[filled]] -= share", "entries[joints.fill[filled]] -= 0.0 * share"),),
    ),
    Fault(
        "compiled means at inlets",
        STRAIGHT_TREES,
        (("by_flow[n, v] - 0.5 * fall[n, v]", "by_flow[n, v] - 0.0 * fall[n, v]"),),
    ),
    Fault(
        "compiled waves that no bed turns back", STRAIGHT_TREES, (("1.0 + load[v, k] *", "1.0 + 0.0 * load[v, k] *"),)
    ),
    Fault("compiled walls without viscosity", STRAIGHT_TREES, (("omega[k] * delay", "omega[k] * 0.0"),)),
    Fault(
        "viscous compliance as an elastic one",
        "pulse/model/linear.py",
        (("return 1.0 + 1j * omega * _retardation", "return 1.0 + 0j * omega * _retardation"),),
    ),
    Fault(
        "no gain at the ends of tapers",
        "pulse/solver/changing.py",
        (("nodes.gain[e] = 2.0 *", "nodes.gain[e] = 0.0 *"),),
    ),
    Fault("energy lost along tapers", "pulse/solver/changing.py", (("flow[j] += 0.5 *", "flow[j] += 0.0 *"),)),
    Fault(
        "drag of tapers as of their faces",
        "pulse/solver/grid.py",
        (("cells.dt[self.changing.cell] *=", "cells.dt[self.changing.cell] *= 1.0 or"),),
    ),
    Fault(
        "no energy in the derivatives along tapers",
        "pulse/solver/changing.py",
        (("energy[1, j] * face_dA[j] + energy[2, j] * face_dq[j]", "energy[1, j] * face_dA[j]"),),
    ),
    Fault(
        "drag of tapers as it was in their derivatives",
        "pulse/solver/varied_stepper.py",
        (("row[cells] = direction", "row[cells] = 0.0 * direction"),),
    ),
    Fault(
        "junctions of the total pressure take it for the static one",
        "pulse/solver/nodes.py",
        (("head = (0.5 * by_speed + ends.viscous[e]) * u\n", "head = (0.25 * by_speed + ends.viscous[e]) * u\n"),),
    ),
    Fault(
        "narrowings that take the drag of their cells twice",
        "pulse/model/model.py",
        (("np.maximum(resistance - vessel_resistance, 0.0)", "resistance"),),
    ),
    Fault(
        "losses that give energy",
        "pulse/solver/nodes.py",
        (("u + ends.loss[e] * abs(u)\n        max_step", "u - ends.loss[e] * abs(u)\n        max_step"),),
    ),
    Fault(
        "derivatives as of static junctions",
        "pulse/solver/node_variations.py",
        (("slopes.by_flow[e] * changes.flow[e]", "0.0 * changes.flow[e]"),),
    ),
    Fault(
        "waves that no flow carries",
        "pulse/model/linear.py",
        (("carried.append(1j", "carried.append(0j"),),
    ),
    Fault(
        "tapers believed as they are",
        "pulse/network/network.py",
        (("prior**2 / (prior**2 + sd**2)", "prior**2 / prior**2"),),
    ),
    Fault(
        "errors of radii forgotten",
        UNKNOWNS,
        (("radii[measured] = radius_sd[measured]", "radii[measured] *= radius_sd[measured] > 0 #"),),
    ),
    Fault(
        "halves know each other's modes",
        "pulse/inference/mixture.py",
        (
            (
                "members = [i for i, component in enumerate(components) if half in component.halves]",
                "members = [i for i, component in enumerate(components)]",
            ),
        ),
    ),
    Fault(
        "components count regardless of their draws",
        "pulse/inference/mixture.py",
        (("+ np.log(np.mean(component == i))", "+ 3.0 * i"),),
    ),
    Fault(
        "emulators learn the top of the posterior alone",
        "pulse/inference/rounds.py",
        (("_LEARNED_POWER = 0.6", "_LEARNED_POWER = 4.0"),),
    ),
    Fault(
        "walkers start at the top of a ridge alone",
        "pulse/inference/rounds.py",
        (("ridge = [mode.middle, *_ridge(target, mode, rng)]", "ridge = [mode.middle]"),),
    ),
    Fault(
        "draws of a wider density taken for the posterior's",
        "pulse/inference/mixture.py",
        (("source.surrogate.log_drawn(points) - cloud", "source.surrogate.log_posterior(points) - cloud"),),
    ),
]


def broken(text: str, fault: Fault) -> str:
    """Return the source with the fault in it; ValueError where it does not fit."""
    for old, new in fault.edits:
        if (count := text.count(old)) != 1:
            raise ValueError(f"{fault.name}: {fault.file} contains {old!r} {count} times, not once")
        text = text.replace(old, new)
    return text


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """Run Python so that `import vasowave` takes the copy of the source in `folder`.

    All copies share what is compiled: it is kept by the source of each kernel, so only what a fault touches is new.
    """
    environment = {"NUMBA_CACHE_DIR": str(KERNELS), **os.environ}
    environment |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, *command],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
    )


def first_failure(fault: Fault | None) -> str | None:
    """Run the tests on a copy of the source with the fault in it; return the test that failed, or None."""
    with tempfile.TemporaryDirectory(prefix="planted-fault-") as name:
        folder = Path(name).resolve()
        shutil.copytree(ROOT / "src", folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
        if fault:
            path = folder / "vasowave" / fault.file
            path.write_text(broken(path.read_text(encoding="utf-8"), fault), encoding="utf-8")
        imported = run(folder, "-c", "import vasowave; print(vasowave.__file__)").stdout.strip()
        if Path(imported) != folder / "vasowave" / "__init__.py":
            raise RuntimeError(f"the copy in {folder} was not imported, but {imported or 'nothing'}")
        done = run(folder, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *TESTS)
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    if done.returncode == 0:
        return None
    if done.returncode != 1 or not failed:
        raise RuntimeError(f"the tests ended with code {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return failed[1]


def main(words: list[str]) -> int:
    """Plant the faults whose name contains one of `words` (all of them by default); print one row for each."""
    chosen = [fault for fault in FAULTS if not words or any(word in fault.name for word in words)]
    if not chosen:
        print(f"no fault is named like that; there are: {', '.join(fault.name for fault in FAULTS)}")
        return 2
    survived = 0
    try:
        for fault in chosen:
            broken((ROOT / "src" / "vasowave" / fault.file).read_text(encoding="utf-8"), fault)
        if failed := first_failure(None):
            raise RuntimeError(f"{failed} fails without any fault")
        width = max(len(fault.name) for fault in chosen)
        for fault in chosen:
            failed = first_failure(fault)
            survived += failed is None
            print(f"{fault.name:{width}}  {failed or 'SURVIVED'}", flush=True)
    except (RuntimeError, ValueError, subprocess.TimeoutExpired) as error:
        print(error)
        return 2
    print(f"{len(chosen) - survived} of {len(chosen)} planted faults caught")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
