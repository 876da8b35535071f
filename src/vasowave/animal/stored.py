"""From stored results back to the model that was fitted: it can be simulated, changed and swept again."""

import json
from collections.abc import Mapping
from typing import Any

import xarray as xr

from vasowave.animal.animal import Settings
from vasowave.animal.reading import data_of, network, settings_of, wall_laws
from vasowave.blood import FRICTIONS, Blood
from vasowave.errors import InputError, did_you_mean
from vasowave.findings import from_json
from vasowave.laws import find_law
from vasowave.model import Model
from vasowave.outlets import Windkessel
from vasowave.recording import Recording
from vasowave.solver import Numerics


def stored_recording(result: xr.DataTree) -> Recording:
    """Return the averaged cycle of an animal's stored results, with its notes and the errors of its harmonics."""
    data = data_of(result, "recording")
    errors = {name: data[name].values for name in ("pressure_error", "flow_error") if name in data}
    return Recording(data["pressure"].values, data["flow"].values, float(data.attrs["period"]), data.attrs["source"],
                     from_json(data.attrs["findings"]), **errors)  # fmt: skip


def stored_settings(result: xr.DataTree) -> Settings:
    """Return the settings that an animal was analyzed with."""
    data = settings_of(result)
    return Settings(**data | {"blood": _blood(data["blood"]), "numerics": Numerics(**data["numerics"])})


def _blood(data: Mapping[str, Any]) -> Blood:
    friction = dict(data["friction"])
    kind = {one.__name__: one for one in FRICTIONS.values()}[friction.pop("law")]
    return Blood(data["density"], data["viscosity"], kind(**friction))


def stored_model(result: xr.DataTree, wall: str = "") -> Model:
    """Return the model that was fitted to an animal, to the last bit.

    Parameters
    ----------
    result : DataTree
        Of one animal, as `read_results` gives it.
    wall : str
        The wall law; by default the first that was fitted.

    Raises
    ------
    InputError
        The results hold no fit with this law.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1))
    >>> vw.stored_model(result)
    Model(LinearWall(beta ...), Windkessel, Network(21 vessels, ...))
    """
    known = list(wall_laws(result))
    wall = wall or known[0]
    if wall not in known:
        raise InputError(f"no fit with the wall law '{wall}'{did_you_mean(wall, known)}; there are: {', '.join(known)}")
    data = data_of(result, f"{wall}/calibration")
    law = find_law(wall)
    blood = _blood(
        {
            "density": data.attrs["blood_density_g_per_ml"],
            "viscosity": data.attrs["blood_viscosity_cm2_per_s"],
            "friction": json.loads(data.attrs["friction"]),
        }
    )
    outlets = Windkessel(*(data[name].values for name in Windkessel._fields))
    return Model(network(result), law(*(data[name].values for name in law._fields)), outlets, blood)
