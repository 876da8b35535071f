"""
A study: from files to a posterior and a comparison of groups
=============================================================

A folder of networks and recordings becomes results; one animal's posterior says how sure its parameters are, and the
primary comparison how the groups differ. The mice are synthetic; your own folder is made by `vasowave new`.
"""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt

import vasowave as vw
from vasowave.study.entering import write_virtual_study

folder = Path(tempfile.mkdtemp())
study_file = write_virtual_study(folder / "study")  # networks, recordings, a table of 7 + 5 animals

# %%
# One animal, by hand: its vessels, its continuous recording, and the beats of it.
network = vw.read_network(folder / "study" / "networks" / "ctl.csv")
raw = vw.read_raw_recording(folder / "study" / "recordings" / "ctl-1.txt")
beats = raw.average(20)
raw.plot(slice(0, 1))
beats.plot()

# %%
# The wall's stiffness that explains it, and how sure that is when the image and the model are uncertain, too.
fit = vw.calibrate(network, beats, "linear", starts=2)
print(fit.summary().head(8))
posterior = fit.sample(draws=100, numerics=vw.Numerics(cell_size=0.4, samples=128))
print(posterior.summary.loc[["beta", "R_T", "wave_speed"], ["median", "interval_low", "interval_high", "unit"]])

# %%
# The same draws, two quantities against each other.
figure, axes = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
fit.plot.pressure(axes[0])
axes[1].plot(posterior.draws("R_T").ravel(), posterior.draws("wave_speed").ravel(), ".")
axes[1].set(xlabel="R_T [mmHg s/ml]", ylabel="wave speed [cm/s]")

# %%
# All animals. What a study file says is declared in one class, and its template is made from it.
study_file.write_text("calibration: {walls: [linear], starts: 1}\nmodel_selection: false\n", encoding="utf-8")
with ThreadPoolExecutor(1) as threads:
    vw.run_study(vw.read_study(study_file), executor=threads)
results = vw.read_results(study_file.parent)
table = results.table()
print(table[table["quantity"] == "wave_speed"].pivot_table("value", "group", "law"))

# %%
# The comparison that the report shows: one family of quantities, one p.
comparison = results.compare("HPH", "CTL")
print(comparison)
comparison.forest()
