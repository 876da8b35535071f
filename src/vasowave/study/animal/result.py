"""The result of one animal as a value; `to_datatree` and `from_datatree` alone know how it is stored.

::

    /                        attributes: see `_attributes`
    ├── network              topology and morphometry, by vessel
    ├── recording            measured pressure and flow, hemodynamic indices
    ├── nominal              what the fits started from
    ├── measured             waves, impedance, quantities
    ├── beats, ventricle, loops, selection, averages, laws
    └── linear, tangent, …   one group per wall law: calibration, simulation, waves, impedance, tree, quantities,
                             stiffening, sites, and inference with the groups that ArviZ reads
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, as_json, from_json, shared, texts
from vasowave.base.notebook import card
from vasowave.base.stores import parsed_as
from vasowave.pulse.inference.known_errors import AssumedError
from vasowave.pulse.network.network import MEASURED, Network
from vasowave.study.animal.failure import Failure, as_plain
from vasowave.study.animal.labelled import labelled
from vasowave.study.animal.law_result import LawResult, Measured, PosteriorResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KIND = "vasowave animal"
"""Title of what is stored; anything with another title is not one of ours."""

FAILURES = "failures"
"""Attribute that holds what failed, a JSON list."""

ERRORS = "assumed_errors"
"""Attribute that holds the errors that intervals allow for, a JSON list of name, SD, unit and source."""

TIDY_COLUMNS = ("animal", "group", "law", "quantity", "value", "low", "high", "unit")
"""Columns of a table of single numbers."""

_ATTRIBUTES = ("title", "Conventions", "animal", "group", "synthetic", "interrupted", "findings", FAILURES, "settings",
               ERRORS)  # fmt: skip
_REQUIRED_GROUPS = ("recording", "nominal")  # groups of an animal that are a field of the same name
_OPTIONAL_GROUPS = {"beats": "beats", "ventricle": "ventricle", "loops": "loops", "evidence": "laws",
             "selection": "selection", "averages": "averages"}  # field: group  # fmt: skip
_OTHER_GROUPS = {"network", "measured", *_REQUIRED_GROUPS, *_OPTIONAL_GROUPS.values()}
_LAW_GROUPS = {"calibration": "calibration", "simulation": "simulation", "waves": "waves", "impedance": "impedance",
           "vessels": "tree", "quantities": "quantities"}  # fmt: skip
_OPTIONAL_LAW_GROUPS = ("stiffening", "sites")  # parts of a law that not every one has, and their groups
_MEASURED_VARIABLES = {
    "radius_sd": ("cm", "standard deviation of the radius, NaN where not known"),
    "taper": ("1", "fall of the radius along the vessel, NaN where not measured"),
    "taper_sd": ("1", "standard deviation of the taper"),
    "radius_scale_sd": ("1", "standard deviation of a factor that all radii have in common, NaN where not known"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class AnimalResult:
    """Everything about one animal, as `analyze` returns and `read_results` reads it.

    Attributes
    ----------
    name, group : str
    network : Network
        With all that is known of its vessels.
    recording : Dataset
        Measured pressure and flow, their scatter over the beats, indices; attributes ``period, source, findings``.
    nominal : Dataset
        Nominal parameters, the samples behind Z_c and τ, outlets by terminal.
    measured : Measured
    laws : dict of str to LawResult
        By the name of the wall law, in the order of the settings.
    beats : Dataset, optional
        Onset, length and fate of every beat, a stretch of the signals; of a continuous recording.
    ventricle : Dataset, optional
        Pressure in the ventricle, and the elastance and volume that make it.
    loops : Dataset, optional
        Loops of pressure and volume, beat by beat, their ends of systole and the line through these.
    evidence : Dataset, optional
        What the posteriors of several laws say of them.
    selection : Dataset, optional
        AICc and BIC of every wall law under every noise model.
    averages : Dataset, optional
        Weights of the laws; quantities averaged over them, with intervals.
    synthetic : bool
        Whether the animal was made and not measured.
    interrupted : bool
        Whether Ctrl-C ended the search.
    noticed : tuple of Finding
        On the way, beside what is known of the recording, of a fit, or of a posterior.
    failures : tuple of Failure
        What of the laws failed, and why.
    settings : dict
        Those it was analyzed with.
    origin : dict of str to str
        Versions of the programs, SHA-256 of the inputs.
    assumed_errors : tuple of AssumedError
        The errors of image, probe, transducer and wall that intervals and standard errors of fits allow for: what it
        is, its SD, and whether the lab, the image or nobody told it.
    looks : tuple of Finding
        What asks for a look at its files, as `check` says; it is not stored.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1))
    >>> print(str(result).partition(",")[0])
    AnimalResult('mouse 6'
    >>> result.laws["linear"].quantities["R_T"].attrs["units"]
    'mmHg s/ml'
    >>> result.to_datatree()["linear/quantities/R_T"].identical(result.laws["linear"].quantities["R_T"])
    True
    """

    name: str
    group: str
    network: Network
    recording: xr.Dataset
    nominal: xr.Dataset
    measured: Measured
    laws: Mapping[str, LawResult] = field(default_factory=dict)
    beats: xr.Dataset | None = None
    ventricle: xr.Dataset | None = None
    loops: xr.Dataset | None = None
    evidence: xr.Dataset | None = None
    selection: xr.Dataset | None = None
    averages: xr.Dataset | None = None
    synthetic: bool = False
    interrupted: bool = False
    noticed: tuple[Finding, ...] = ()
    failures: tuple[Failure, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    origin: Mapping[str, str] = field(default_factory=dict)
    assumed_errors: tuple[AssumedError, ...] = ()
    looks: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a law whose group another part has."""
        check_law_names(self.laws)

    def __repr__(self) -> str:
        rows = [f"  {name:<{max(map(len, self._facts))}}  {text}" for name, text in self._facts.items()]
        return "\n".join([f"AnimalResult('{self.name}', {self.group})", *rows])

    def _repr_html_(self) -> str:
        return card(f"{self.name}, {self.group}", self._facts, texts(self.findings))

    @property
    def _facts(self) -> dict[str, str]:
        """The numbers that a person looks for first, by their source."""
        return {name: source.numbers for name, source in self.sources.items()}

    @property
    def sources(self) -> dict[str, Measured]:
        """The sources of numbers: ``measured``, and every wall law."""
        return {"measured": self.measured, **self.laws}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings that a reader must know: of the recording, the analysis, the fits and the posteriors."""
        recorded = from_json(self.recording.attrs.get("findings", "[]"))
        fitted = shared({name: law.findings for name, law in self.laws.items()})
        posteriors = {name: law.posterior for name, law in self.laws.items() if law.posterior is not None}
        drawn = [finding.at(law=name) for name, posterior in posteriors.items() for finding in posterior.findings]
        return tuple(dict.fromkeys([*recorded, *self.noticed, *fitted, *drawn]))

    @property
    def period(self) -> float:
        """T, s."""
        return float(self.recording.attrs["period"])

    @property
    def root(self) -> str:
        """Name of the root vessel."""
        return self.network.name[self.network.root]

    @property
    def plot(self) -> "FitPlots":
        """Panels: ``result.plot.pressure(ax)``, ``residuals``, ``autocorrelation``, ``pressure_area``, ..."""
        return FitPlots(self)

    def table(self) -> pd.DataFrame:
        """Return the single numbers of the recording and of every law, a row each.

        Columns ``animal, group, law`` ("measured" for the recording), ``quantity``, ``value, low, high`` (95 %,
        NaN where nothing tells it), ``unit``.
        """
        tables = [source.summary().reset_index().assign(animal=self.name, group=self.group, law=law)
                 for law, source in self.sources.items()]  # fmt: skip
        return pd.concat(tables, ignore_index=True)[[*TIDY_COLUMNS]]

    def at_inlets(self) -> "AnimalResult":
        """Return the result with, of every simulation, only pressure and flow at the inlet of the root vessel.

        That is all that most of a report asks of an animal, and a tenth of its size.
        """

        def light(law: LawResult) -> LawResult:
            waves = law.simulation[["pressure", "flow"]]
            return replace(law, simulation=waves.sel(vessel=[self.root], station=["inlet"]))

        return replace(self, laws={name: light(law) for name, law in self.laws.items()})

    def identical(self, other: "AnimalResult") -> bool:
        """Whether everything that is stored of the two is the same: values, names, units and attributes."""
        return self.to_datatree().identical(other.to_datatree())

    def to_datatree(self) -> xr.DataTree:
        """Return the result as it is stored; its groups and attributes are described in docs/results.md."""
        groups = {"network": network_dataset(self.network)} | {name: getattr(self, name) for name in _REQUIRED_GROUPS}
        groups |= {f"measured/{name}": data for name, data in vars(self.measured).items()}
        if self.beats is not None:
            groups["beats"] = self.beats
        for name, law in self.laws.items():
            groups |= {f"{name}/{group}": getattr(law, field) for field, group in _LAW_GROUPS.items()}
            groups |= {
                f"{name}/{field}": data for field in _OPTIONAL_LAW_GROUPS if (data := getattr(law, field)) is not None
            }
            if law.posterior is not None:
                groups[f"{name}/inference"] = law.posterior.table
                groups |= {f"{name}/inference/{field}": data for field, data in law.posterior.groups.items()}
        groups |= {
            group: data for field, group in _OPTIONAL_GROUPS.items() if (data := getattr(self, field)) is not None
        }
        tree = xr.DataTree.from_dict({f"/{name}": dataset for name, dataset in groups.items()})
        tree.attrs = _attributes(self)
        return tree

    @classmethod
    def from_datatree(cls, tree: xr.DataTree) -> "AnimalResult":
        """Return the result that `to_datatree` made a tree of.

        Raises
        ------
        InputError
            A group is missing, or the tree is not the result of one animal.
        """
        if tree.attrs.get("title") != KIND:
            raise InputError(f"not the result of one animal (its title is not '{KIND}')")
        attrs = tree.attrs
        measured = {name: _data(tree, f"measured/{name}") for name in ("waves", "impedance", "quantities")}
        fields: dict[str, Any] = {name: _data(tree, name) for name in _REQUIRED_GROUPS}
        fields |= {field: _data(tree, group) for field, group in _OPTIONAL_GROUPS.items() if group in tree.children}
        settings = parsed_as(dict[str, Any], attrs.get("settings", "{}"))
        laws = {name: _law(tree, name) for name, node in tree.children.items() if "calibration" in node.children}
        return cls(
            name=str(attrs["animal"]),
            group=str(attrs["group"]),
            network=network_of(_data(tree, "network")),
            measured=Measured(**measured),
            laws=as_chosen(laws, settings.get("walls", ())),
            synthetic=bool(int(attrs.get("synthetic", 0))),
            interrupted=bool(int(attrs.get("interrupted", 0))),
            noticed=from_json(attrs.get("findings", "[]")),
            failures=parsed_as(tuple[Failure, ...], attrs.get(FAILURES, "[]")),
            settings=settings,
            assumed_errors=parsed_as(tuple[AssumedError, ...], attrs.get(ERRORS, "[]")),
            origin={str(key): value for key, value in attrs.items() if key not in _ATTRIBUTES},
            **fields,
        )


def check_law_names(names: Iterable[str]) -> None:
    """Raise `InputError` for the name of a wall law whose group another part of every result has."""
    for name in names:
        if name in _OTHER_GROUPS:
            raise InputError(f"wall law '{name}': a part of every result has this name; take another")


def as_chosen(laws: Mapping[str, LawResult], walls: Sequence[str]) -> dict[str, LawResult]:
    """Return the laws in the order in which settings name them, which files do not keep; others come last."""

    def place(name: str) -> int:
        names = (name, laws[name].calibration.attrs.get("law"))
        return next((place for place, wall in enumerate(walls) if wall in names), len(walls))

    return {name: laws[name] for name in sorted(laws, key=place)}


def _attributes(result: AnimalResult) -> dict[str, Any]:
    values = (
        KIND, "CF-1.11", result.name, result.group, int(result.synthetic), int(result.interrupted),
        as_json(result.noticed), json.dumps(as_plain(result.failures), ensure_ascii=False),
        json.dumps(result.settings, sort_keys=True), json.dumps(result.assumed_errors),
    )  # fmt: skip
    return dict(zip(_ATTRIBUTES, values, strict=True)) | dict(result.origin)


def _data(tree: xr.DataTree, path: str) -> xr.Dataset:
    node = tree
    for name in path.split("/"):
        if name not in node.children:
            raise InputError(f"the result of this animal holds no group '{path}'")
        node = node.children[name]
    return node.to_dataset(inherit=False)


def _law(tree: xr.DataTree, name: str) -> LawResult:
    node, posterior = tree.children[name], None
    if "inference" in node.children:
        groups = {
            str(key): group.to_dataset(inherit=False) for key, group in node.children["inference"].children.items()
        }
        posterior = PosteriorResult(_data(node, "inference"), groups)
    fields: dict[str, Any] = {field: _data(node, field) for field in _OPTIONAL_LAW_GROUPS if field in node.children}
    fields |= {field: _data(tree, f"{name}/{group}") for field, group in _LAW_GROUPS.items()}
    return LawResult(name=name, posterior=posterior, **fields)


def network_dataset(network: Network) -> xr.Dataset:
    """Return topology and morphometry by vessel; the root's parent is empty; the nodes are those of graphs alone."""
    parents = [network.name[row] if row >= 0 else "" for row in network.parent]
    measured = {name: values for name in MEASURED if (values := getattr(network, name)) is not None}
    ends = {} if network.nodes is None else {"start": network.start, "end": network.end}
    return xr.Dataset(
        {
            "parent": ("vessel", np.array(parents, dtype=object), {"long_name": "name of the parent vessel"}),
            **{
                f"{end}_node": xr.Variable("vessel", node, {"long_name": f"number of the node at its {end}"})
                for end, node in ends.items()
            },
            "length": labelled("vessel", network.length, "cm", "length"),
            "radius": labelled("vessel", network.radius, "cm", "radius at the pressure of the image"),
            "image_pressure": labelled((), network.pressure, "mmHg", "pressure of the image, 0 where not known"),
            "flow_fraction": labelled("vessel", network.flow_fraction, "1", "share of the root's mean flow (eq. 11)"),
            **{name: labelled("vessel", values, *_MEASURED_VARIABLES[name]) for name, values in measured.items()},
        },
        coords={"vessel": np.array(network.name, dtype=object)},
    )  # fmt: skip


def network_of(data: xr.Dataset) -> Network:
    """Return the network that `network_dataset` made a dataset of, with all that is known of its vessels."""
    names = tuple(map(str, data["vessel"].values))
    rows = {name: row for row, name in enumerate(names)} | {"": -1}
    parent = np.array([rows[str(name)] for name in data["parent"].values])
    measured = {name: data[name].values for name in MEASURED if name in data}
    if "start_node" in data:
        measured["nodes"] = np.column_stack([data["start_node"].values, data["end_node"].values])
    pressure = float(data["image_pressure"]) if "image_pressure" in data else 0.0
    return Network(names, parent, data["length"].values, data["radius"].values, None, pressure, **measured)


@dataclass(frozen=True, eq=False)
class FitPlots:
    """The panels of a fit. Each takes matplotlib axes, or makes a figure, and returns the axes.

    Attributes
    ----------
    result : AnimalResult
        Of the animal, as `animal.analyze` returns it.
    color : str, optional
        Of the wall laws' curves; data are black.
    shaded : bool
        Whether laws differ by shades of it as in the report, or by their dashes alone.
    """

    result: AnimalResult
    color: str | None = None
    shaded: bool = True

    @Accessor
    def panels(self) -> dict[str, str]:
        """Return the names of all panels, and what each shows."""
        raise NotImplementedError

    @Accessor
    def draw(self, name: str, ax: "Axes | None" = None) -> "Axes":
        """Draw the panel of a name; ``result.plot.pressure(ax)`` does it with that of ``pressure``."""
        raise NotImplementedError

    def __getattr__(self, name: str) -> Callable[..., "Axes"]:
        """Return what draws the panel of a name."""
        if name.startswith("_") or name not in (names := self.panels()):
            raise AttributeError(f"there is no panel '{name}'; `panels()` lists them", name=name, obj=self)
        drawn = partial(self.draw, name)
        drawn.__doc__ = names[name]
        return drawn

    def __dir__(self) -> list[str]:
        """Return the names of methods and panels."""
        return [*super().__dir__(), *self.panels()]

    @Accessor
    def save(
        self,
        path: str | Path,
        panels: Sequence[str],
        *,
        width: float = 170.0,
        height: float = 60.0,
        font: float = 8.0,
        family: str = "sans-serif",
        color: str | None = None,
    ) -> Path:
        """Write panels side by side as one figure, ``fit.plot.save("fit.pdf", ["pressure", "impedance"])``.

        Parameters
        ----------
        path : path
            It ends in .svg, .pdf or .png.
        panels : sequence of str
            Names of the panels here, from left to right.
        width, height : float
            mm.
        font : float
            Size of the letters, pt.
        family : str
            Font: ``sans-serif``, ``serif``, ``monospace``, or the name of one that is installed.
        color : str, optional
            Of the wall laws' curves, ``"#d6259b"`` or a name that matplotlib knows, exactly so; data are black. Without
            one they have the shades of the report.

        Raises
        ------
        InputError
            No such panel, font or color, or the file cannot be written.
        """
        raise NotImplementedError
