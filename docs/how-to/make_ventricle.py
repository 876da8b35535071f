"""Simulate a heart before the control network and write what would be recorded: `python make_ventricle.py`."""

import numpy as np

import vasowave as vw

network, mouse = vw.control_network(), vw.virtual_mouse()
model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
heart = vw.Ventricle.from_peak(1400.0, rest=100.0, period=0.11, filling_pressure=4.0)
waves = vw.simulate(model, heart, vw.Numerics(samples=256))
root = waves.sel(vessel=network.name[network.root], station="inlet")
flow = np.clip(root.flow, 0, None)
pressure = waves.ventricular_pressure.to_numpy().copy()
empty = 150  # relaxed: from here on it fills again, which the model does in no time
pressure[empty:] = np.linspace(pressure[empty], 4.0, len(pressure) - empty)
vw.write_network(network, "network.csv")
np.savetxt(
    "recording.csv",
    np.column_stack([waves.time, root.pressure, flow]),
    "%.5f",
    ",",
    header="# SYNTHETIC\ntime [s],pressure [mmHg],flow [ml/s]",
    comments="",
)
np.savetxt(
    "rv.csv",
    np.column_stack([waves.time, pressure]),
    "%.5f",
    ",",
    header="time [s],pressure [mmHg]",
    comments="",
)
