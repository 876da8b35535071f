"""
Waves in ParaView
=================

A cycle as tubes that pulsate, written without VTK and played by ParaView.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import vasowave as vw
from vasowave.study.exchange import drawn_axes

network, mouse = vw.control_network(), vw.virtual_mouse()
nominal = vw.estimate_nominal(network, mouse)
model = vw.Model(network, nominal.wall(vw.LinearWall), nominal.outlets)
folder = Path(tempfile.mkdtemp())
for sentence in vw.export_model(model, mouse, "paraview", folder):
    print(sentence)
print(sorted(path.name for path in folder.iterdir()), len(list((folder / "frames").iterdir())), "frames")

# %%
# A network without coordinates is drawn as a flat tree, with true lengths.
figure, ax = plt.subplots(figsize=(6, 4), layout="constrained")
for axis, radius in zip(drawn_axes(network), network.radius, strict=True):
    ax.plot(axis[:, 0], axis[:, 1], color="tab:red", linewidth=150 * radius, solid_capstyle="round")
ax.set(xlabel="x [cm]", ylabel="y [cm]", aspect="equal")
