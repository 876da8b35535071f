"""
What would happen if: a sweep
=============================

Every combination of some values, with the values as coordinates.
"""

import matplotlib.pyplot as plt

import vasowave as vw

network, mouse = vw.control_network(), vw.virtual_mouse()
nominal = vw.estimate_nominal(network, mouse)
model = vw.Model(network, nominal.wall(vw.LinearWall), nominal.outlets)
found = vw.sweep(model, mouse, {"beta": [30.0, 60.0, 120.0], "R_T": [60.0, 90.0, 120.0]})
print(found.sizes)

# %%
# Stiffer walls raise the pulse, more resistance raises the mean.
root = found.sel(vessel=network.name[network.root])
figure, axes = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
for ax, name in zip(axes, ("mean_pressure", "pulse_pressure"), strict=True):
    for R_T in found.R_T.values:
        ax.plot(found.beta, root[name].sel(R_T=R_T), "o-", label=f"R_T {R_T:g} mmHg s/ml")
    ax.set(xlabel="β [mmHg]", ylabel=f"{name.replace('_', ' ')} [mmHg]")
axes[0].legend(fontsize="small")
