"""One way out: a model simulated once, and written for another program."""

from collections.abc import Callable
from pathlib import Path

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.files import check_writable, write_folder
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.study.exchange.matlab import write_matlab
from vasowave.study.exchange.openbf import write_openbf
from vasowave.study.exchange.paraview import drawn_axes, read_axes, write_paraview
from vasowave.study.exchange.solved import Solved, solve
from vasowave.study.exchange.svzerod import write_svzerod
from vasowave.study.exchange.tables import write_tables

_WRITERS: dict[str, Callable[[Solved, Path], list[str]]] = {
    "matlab": write_matlab,
    "openbf": write_openbf,
    "svzerod": write_svzerod,
    "tables": write_tables,
}
_DRAWN = "The network has no coordinates: vessels were drawn as a flat tree, with true lengths and radii."
_CHANGING = {
    "openbf": "Vessels that change on their way have openBF's straight taper, its one thickness of the wall, and its "
    "junctions of one static pressure.",
    "svzerod": "Vessels that change on their way are taken as they are in the middle.",
}

FORMATS = ("paraview", *_WRITERS)
"""What a model can be exported to."""


def export_model(
    model: Model,
    inflow: Inflow | Recording,
    program: str,
    folder: str | Path,
    *,
    centerlines: str | Path | None = None,
    numerics: Numerics | None = None,
) -> tuple[str, ...]:
    """Simulate a model and write it, and its waves, into a folder as another program reads it.

    ``paraview``: tubes with pressure, flow, area and velocity, one file a frame. ``matlab``: waves and parameters with
    units. ``openbf``: its YAML and inlet file. ``svzerod``: a lumped model as JSON. ``tables``: CSV.

    Parameters
    ----------
    model : Model
    inflow : Inflow or Recording
    program : {"paraview", "matlab", "openbf", "svzerod", "tables"}
    folder : path
        Is made; other files in it stay.
    centerlines : path, optional
        For ParaView, the ``centerlines.csv`` of the extraction that made the network; without it, vessels are drawn.
    numerics : Numerics, optional

    Returns
    -------
    tuple of str
        Sentences on what the files hold, and where they leave the model.

    Raises
    ------
    InputError
        An unknown program, a folder that cannot be written, a model that the program cannot hold.
    NumericalError
        As `simulate`.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> model = vw.Model(network, nominal.wall(vw.TangentWall), nominal.outlets)
    >>> for sentence in vw.export_model(model, mouse, "svzerod", "lung-0d"):
    ...     print(sentence)
    Run it with: svzerodsolver svzerod.json result.csv. ...
    """
    if program not in FORMATS:
        raise InputError(
            f"unknown program '{program}'{did_you_mean(program, FORMATS)}; there are: {', '.join(FORMATS)}"
        )
    folder = Path(folder)
    if folder.is_file():
        raise InputError(f"{folder} is a file; give the name of a folder")
    check_writable(folder)
    axes = read_axes(centerlines, model.network) if centerlines is not None else drawn_axes(model.network)
    solved = solve(model, inflow, numerics)
    with write_folder(folder) as fresh:
        if program != "paraview":
            remarks = _WRITERS[program](solved, fresh)
            return tuple([*remarks, _CHANGING[program]] if program in _CHANGING and model.changing.any() else remarks)
        remarks = write_paraview(solved, fresh, axes)
    return tuple(remarks if centerlines is not None else [*remarks, _DRAWN])
