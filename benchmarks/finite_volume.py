"""The equations of the model by a second, independent method, for trees with the linear wall.

    python benchmarks/finite_volume.py --docs      the cases of Boileau et al. (2015): minutes; into docs/performance.md

Finite volumes on cells: pressure and flow are straight lines in every cell (van Leer's limiter), what leaves a face is
the solution of two acoustic waves that meet there, and time goes by Heun's steps. Ends of vessels follow the line of
the characteristic that leaves them. It shares no line with the solver, is of second order, and slow.
"""

import argparse
import warnings
from pathlib import Path

import numpy as np
from numba import njit

import vasowave as vw
from robustness_page import put
from vasowave.pulse.model import Resistance, Windkessel
from vasowave.study.exchange import read_openbf

PAGE = Path(__file__).parents[1] / "docs" / "performance.md"
DATA = Path(__file__).parents[2] / "shared" / "data"
CASES = {
    "common carotid artery": "benchmarks/boileau2015_inputs_openBF/cca/cca.yaml",
    "upper thoracic aorta": "benchmarks/boileau2015_inputs_openBF/uta/uta.yaml",
    "aorta that divides": "benchmarks/boileau2015_inputs_openBF/ibif/ibif.yaml",
    "37 vessels in vitro": "openbf/current/matthys2007/invitro_model.yaml",
    "ADAN56, 77 tapering vessels": "openbf/current/adan56/adan56.yaml",
}
MANY = 50  # vessels: of a larger tree no accuracy is asked, which would take minutes
COURANT, CYCLES, SEEN, CLOSE = 0.8, 40, 200, 1e-4  # CLOSE: of the largest pressure, from cycle to cycle
HEAD = ("case", "vessels", "pressure, mmHg", "pressures differ, r.m.s. (worst vessel)", "flows differ, r.m.s.")


@njit(cache=False)
def slope(a, b):
    """Van Leer's mean of two differences."""
    return 2 * a * b / (a + b) if a * b > 0 else 0.0


@njit(cache=False)
def rates(A, q, charge, inflow, geometry, fluid, tree, bed, dA, dq, dcharge, seen):
    """Time derivatives of area, flow and charge of the beds; `seen` gets pressure and flow at three places a vessel."""
    A0, beta, A0_face, beta_face, dx, first = geometry
    rho, k0, k1 = fluid
    parent = tree
    R1, R2, C, behind, terminal = bed
    vessels = len(dx)
    p = beta * (np.sqrt(A / A0) - 1)
    faces = len(A0_face)
    pf, qf = np.empty(faces), np.empty(faces)
    ends = np.empty((vessels, 2, 3))  # pressure, flow and slope dq/dp of the line that leaves either end
    for v in range(vessels):
        i, k, f = first[v], first[v + 1], first[v] + v
        n = k - i
        sp, sq = np.zeros(n), np.zeros(n)
        for j in range(n):
            if 0 < j < n - 1:
                sp[j] = slope(p[i + j] - p[i + j - 1], p[i + j + 1] - p[i + j])
                sq[j] = slope(q[i + j] - q[i + j - 1], q[i + j + 1] - q[i + j])
            elif n > 1:
                at = i if j == 0 else k - 2
                sp[j], sq[j] = p[at + 1] - p[at], q[at + 1] - q[at]
        for j in range(1, n):
            pl, pr = p[i + j - 1] + 0.5 * sp[j - 1], p[i + j] - 0.5 * sp[j]
            ql, qr = q[i + j - 1] + 0.5 * sq[j - 1], q[i + j] - 0.5 * sq[j]
            mean = A0_face[f + j] * (1 + 0.5 * (pl + pr) / beta_face[f + j]) ** 2
            c = np.sqrt(0.5 * beta_face[f + j] / rho * np.sqrt(mean / A0_face[f + j]))
            Z = rho * c / mean
            pf[f + j], qf[f + j] = 0.5 * (pl + pr + Z * (ql - qr)), 0.5 * (ql + qr + (pl - pr) / Z)
        for end in range(2):
            j, sign, face = (0, -0.5, f) if end == 0 else (n - 1, 0.5, f + n)
            pe, qe = p[i + j] + sign * sp[j], q[i + j] + sign * sq[j]
            Ae = A0_face[face] * (1 + pe / beta_face[face]) ** 2
            c = np.sqrt(0.5 * beta_face[face] / rho * np.sqrt(Ae / A0_face[face]))
            per_p = 2 * np.sqrt(Ae * A0_face[face]) / beta_face[face]
            ends[v, end] = pe, qe, (qe / Ae + (c if end == 0 else -c)) * per_p
    for v in range(vessels):
        f = first[v] + v
        if parent[v] < 0:
            pe, qe, m = ends[v, 0]
            pf[f], qf[f] = pe + (inflow - qe) / m, inflow
        last = first[v + 1] + v
        pe, qe, m = ends[v, 1]
        excess, fall = qe - m * pe, m
        leaves = terminal[v] >= 0
        if leaves:
            b = terminal[v]
            P = (behind[b] + charge[b] + R1[b] * excess) / (1 - R1[b] * m)
        else:
            for d in range(vessels):
                if parent[d] == v:
                    excess -= ends[d, 0, 1] - ends[d, 0, 2] * ends[d, 0, 0]
                    fall -= ends[d, 0, 2]
            P = -excess / fall
        pf[last], qf[last] = P, qe + m * (P - pe)
        if leaves:
            dcharge[b] = (qf[last] - charge[b] / R2[b]) / C[b] if C[b] > 0 else 0.0
        else:
            for d in range(vessels):
                if parent[d] == v:
                    at = first[d] + d
                    pf[at], qf[at] = P, ends[d, 0, 1] + ends[d, 0, 2] * (P - ends[d, 0, 0])
    Af = A0_face * (1 + pf / beta_face) ** 2
    for v in range(vessels):
        f = first[v] + v
        for j in range(first[v], first[v + 1]):
            a = j + v
            dA[j] = -(qf[a + 1] - qf[a]) / dx[v]
            carried = qf[a + 1] ** 2 / Af[a + 1] - qf[a] ** 2 / Af[a]
            dq[j] = -(carried + A[j] / rho * (pf[a + 1] - pf[a])) / dx[v] - (k0 + k1 * np.sqrt(A[j])) / A[j] * q[j]
        middle = first[v] + v + (first[v + 1] - first[v]) // 2
        for place, face in enumerate((f, middle, first[v + 1] + v)):
            seen[v, place, 0], seen[v, place, 1] = pf[face], qf[face]


@njit(cache=False)
def cycle(A, q, charge, inflow, dt, geometry, fluid, tree, bed, kept):
    """Run one cycle by Heun's method; `kept` gets what is seen at evenly spaced times."""
    one, other = (
        (np.zeros_like(A), np.zeros_like(q), np.zeros_like(charge)),
        (np.zeros_like(A), np.zeros_like(q), np.zeros_like(charge)),
    )
    seen = np.zeros((len(geometry[4]), 3, 2))
    steps = len(inflow)
    every = steps // len(kept)
    for n in range(steps):
        rates(A, q, charge, inflow[n], geometry, fluid, tree, bed, one[0], one[1], one[2], seen)
        if n % every == 0:
            kept[n // every] = seen
        A1, q1, c1 = A + dt * one[0], q + dt * one[1], charge + dt * one[2]
        rates(A1, q1, c1, inflow[(n + 1) % steps], geometry, fluid, tree, bed, other[0], other[1], other[2], seen)
        A += 0.5 * dt * (one[0] + other[0])
        q += 0.5 * dt * (one[1] + other[1])
        charge += 0.5 * dt * (one[2] + other[2])


def solved(model: vw.Model, inflow: vw.Inflow, size: float, guess: np.ndarray) -> np.ndarray:
    """Return pressure and flow of the periodic state at three places of each vessel, shape (time, vessel, place, 2).

    Cells have `size` cm or less; `guess` are pressures of the vessels (mmHg) from which it begins.
    """
    network, vessels = model.network, len(model.network)
    counts = np.maximum(np.ceil(network.length / size).astype(int), 3)
    first = np.concatenate([[0], np.cumsum(counts)])
    row = np.repeat(np.arange(vessels), counts)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in counts])
    wall, A0 = model.at(row, share)
    row_f = np.repeat(np.arange(vessels), counts + 1)
    wall_f, A0_f = model.at(row_f, np.concatenate([np.arange(n + 1) / n for n in counts]))
    dx = network.length / counts
    beds, ends = model.outlets, network.terminals
    if isinstance(beds, Resistance):
        R1, R2, C = np.array(beds.R, float), np.ones(len(ends)), np.zeros(len(ends))
    else:
        assert isinstance(beds, Windkessel)
        R1, R2, C = (np.array(value, float) for value in (beds.R1, beds.R2, beds.C))
    behind = np.broadcast_to(np.asarray(model.outlet_pressure, float), len(ends)).copy()
    terminal = np.full(vessels, -1)
    terminal[ends] = np.arange(len(ends))
    A = A0 * (1 + guess[row] / wall.beta) ** 2
    q, charge = np.zeros(len(A)), np.where(C > 0, R2 / (R1 + R2) * (guess[ends] - behind), 0.0)
    speed = 1.4 * np.sqrt(0.5 * wall.beta / model.blood.inertia * np.sqrt(A / A0))
    steps = SEEN * int(np.ceil(inflow.period * np.max(speed / dx[row]) / COURANT / SEEN))
    at_once = R2 * C < 5 * inflow.period / steps  # so small a compliance is none within a step
    R1, C, charge = np.where(at_once, R1 + R2, R1), np.where(at_once, 0.0, C), np.where(at_once, 0.0, charge)
    driven = np.interp(np.arange(steps) / steps, np.arange(len(inflow.flow)) / len(inflow.flow), inflow.flow, period=1)
    geometry = A0, wall.beta, A0_f, wall_f.beta, dx, first
    friction = model.blood.friction.coefficients(model.blood.viscosity, inflow.period)
    fluid, kept = (model.blood.inertia, *friction), np.zeros((SEEN, vessels, 3, 2))
    for _ in range(CYCLES):
        before = kept.copy()
        cycle(
            A,
            q,
            charge,
            driven,
            inflow.period / steps,
            geometry,
            fluid,
            network.parent,
            (R1, R2, C, behind, terminal),
            kept,
        )
        if np.max(np.abs(kept - before)[..., 0]) < CLOSE * np.max(np.abs(kept[..., 0])):
            break
    return kept


def row_of(case: str) -> str:
    """Return the row of one case: how far solver and finite volumes are apart."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model, inflow = read_openbf(DATA / CASES[case])
        asked = None if len(model.network) > MANY else 0.05
        ours = vw.simulate(model, inflow, vw.Numerics(samples=SEEN, accuracy=asked))
    pressure, flow = (ours[name].transpose("time", "vessel", "station").to_numpy() for name in ("pressure", "flow"))
    size = float(np.median(model.network.length)) / 40
    found = solved(model, inflow, size, pressure.mean(axis=(0, 2)))
    apart = np.sqrt(np.mean((pressure - found[..., 0]) ** 2, axis=(0, 2)))
    flows = np.sqrt(np.mean((flow - found[..., 1]) ** 2, axis=(0, 2))) / np.max(np.abs(flow), axis=(0, 2))
    cells = (case, len(model.network), f"{pressure.min():.0f} to {pressure.max():.0f}",
             f"{np.median(apart):.3f} ({apart.max():.3f}) mmHg", f"{100 * np.median(flows):.2f} %")  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--only", help="a word of the only case's name")
    options = parser.parse_args()
    if options.only:
        for case in CASES:
            if options.only in case:
                print(row_of(case), flush=True)
        return
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for case in CASES:
        lines.append(row_of(case))
        print(lines[-1], flush=True)
    if options.docs:
        put("benchmark cases", "\n".join(lines), PAGE)


if __name__ == "__main__":
    main()
