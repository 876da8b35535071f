"""Simulate a ventricle while the vena cava is closed and write what would be recorded: `python make_loops.py`."""

import numpy as np

PERIOD, STEPS = 0.12, 600  # s; steps of a beat
ELASTANCE, ZERO = 2600.0, 0.003  # mmHg/ml, ml
rng, dt = np.random.default_rng(7), PERIOD / STEPS
share = np.arange(STEPS) / STEPS / 0.36  # of the time at which the elastance is largest
active = np.where(share < 1, np.sin(0.5 * np.pi * share) ** 2, np.cos(np.clip(share - 1, 0, 0.5) * np.pi) ** 2)
volume, artery, rows = 0.04, 15.0, []
for beat in range(24):
    filling = 6.0 * (1 - 0.055 * max(beat - 12, 0))  # mmHg
    for activation in active:
        above = volume - ZERO
        pressure = activation * ELASTANCE * above + (1 - activation) * 0.5 * np.expm1(70 * above)
        into, out = max(filling - pressure, 0) / 3.0, max(pressure - artery, 0) / 9.0  # ml/s
        volume += dt * (into - out)
        artery += dt * (out - artery / 75.0) / 0.0012
        rows.append((pressure, 1000 * volume))
pressure, volume = np.array(rows[4 * STEPS :: STEPS // 120]).T  # settled; 1000 samples/s
noisy = pressure + 0.15 * rng.standard_normal(len(pressure)), volume + 0.2 * rng.standard_normal(len(pressure))
time = np.arange(len(pressure)) / 1000
np.savetxt(
    "occlusion.csv",
    np.column_stack([time, *noisy]),
    "%.4f",
    ",",
    header="# SYNTHETIC\ntime [s],RVP [mmHg],RV volume [µl]",
    comments="",
    encoding="utf-8",
)
