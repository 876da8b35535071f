"""
One mouse: from a recording to a calibrated model
=================================================

A network, one averaged cycle of pressure and flow, and the stiffness that explains them.
"""

import matplotlib.pyplot as plt

import vasowave as vw

# %%
# The paper's control network and a synthetic recording; your own files are read by `vw.read_network` and
# `vw.read_recording`.
network, mouse = vw.control_network(), vw.virtual_mouse()
fit = vw.calibrate(network, mouse, "linear", search=vw.Search(starts=1))
print(fit)

# %%
# The model's pressure stands over the measured one.
waves = vw.simulate(fit.model, mouse)
figure, ax = plt.subplots(figsize=(6, 3), layout="constrained")
ax.plot(1e3 * mouse.time, mouse.pressure, "k", label="measured")
root = waves.pressure.sel(vessel=network.name[network.root], station="inlet")
ax.plot(1e3 * waves.time, root, "--", label="linear wall")
ax.set(xlabel="time [ms]", ylabel="pressure [mmHg]")
ax.legend()

# %%
# How well is each parameter known?
print(fit.parameters[["value", "unit"]])
