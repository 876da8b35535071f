"""The networks in three dimensions, any quantity as their color, and the waveforms of the vessel that is picked."""

from typing import Any

import numpy as np
import xarray as xr

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.figures.space import axes_in_space
from vasowave.figures.style import color_stops
from vasowave.report.blocks import Space

_SAMPLES, _FEWER, _MANY = 64, 32, 100  # of each waveform; of each where there are many vessels
_CALLED = {"radius": "radius at mean pressure", "distance": "distance of its end from the inlet", "Z_c": "Z_c"}


def space_block(cohort: Cohort, law: str) -> list[Space]:
    """Return the networks of the shown animals with what one wall law says of every vessel; nothing without the law."""
    shown = {group: result for group, result in cohort.shown.items() if law in result.laws}
    if not shown:
        return []
    networks = [{"label": cohort.name(group), **_network(result, law)} for group, result in shown.items()]
    caption = (
        f"The network in space, with the {law} wall. Drag to turn it, wheel or + and − to zoom, click a vessel for its "
        "waveforms at its middle (grey: the root's). Lengths and radii are measured; directions are drawn, since a "
        "table of vessels does not hold them."
    )
    return [Space("Space", caption, {"stops": color_stops(9), "networks": networks})]


def _network(result: AnimalResult, law: str) -> dict[str, Any]:
    whole, simulation = result.network, result.laws[law].simulation
    names = list(whole.name)
    middle = simulation[["pressure", "flow"]].sel(station="middle", vessel=names)
    step = max(1, middle.sizes["time"] // (_FEWER if len(names) > _MANY else _SAMPLES))
    thinned = middle.isel(time=slice(None, None, step))
    quantities = _quantities(result.laws[law].vessels.sel(vessel=names), middle)
    return {
        "period": result.period,
        "names": names,
        "axes": _rounded(axes_in_space(whole)),
        "radius": _rounded(whole.radius),
        "quantities": [{"label": label, "values": _rounded(values)} for label, values in quantities.items()],
        "pressure": _rounded(thinned["pressure"].transpose("vessel", "time").values),
        "flow": _rounded(thinned["flow"].transpose("vessel", "time").values),
    }


def _quantities(vessels: xr.Dataset, middle: xr.Dataset) -> dict[str, np.ndarray]:
    """Return every number of each vessel by its name and unit: of the waveforms first, then what is stored."""
    pressure, flow = middle["pressure"], middle["flow"]
    known = {
        "mean pressure [mmHg]": pressure.mean("time").values,
        "pulse pressure [mmHg]": (pressure.max("time") - pressure.min("time")).values,
        "mean flow [ml/s]": flow.mean("time").values,
    }
    for name, value in vessels.data_vars.items():
        if value.dims == ("vessel",) and value.dtype.kind in "fi" and name != "mean_pressure":
            called = _CALLED.get(str(name), str(name).replace("_", " "))
            known[f"{called} [{value.attrs['units']}]"] = value.values.astype(float)
    return known


def _rounded(values: np.ndarray) -> Any:
    """Return numbers of four digits as lists; None where there is no number."""
    return np.vectorize(lambda one: float(f"{one:.4g}") if np.isfinite(one) else None, otypes=[object])(values).tolist()
