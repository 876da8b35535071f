"""Bodies of the methods that draw, simulate and average: each value's own part declares them, see `accessors`."""

from vasowave.catheter.ensemble import average_beats
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.analysis.prediction import Prediction
from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.analysis.uncertain import UncertainModel
from vasowave.pulse.analysis.ventricular_function import VentricularFunction
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.model_emulator import ModelEmulator
from vasowave.pulse.inference.sensitivity_of_fits import sensitivity_of
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.simulation import simulate
from vasowave.study.animal.datasets import loops_dataset, recording_dataset
from vasowave.study.animal.files import write_emulator
from vasowave.study.animal.result import FitPlots
from vasowave.study.cohort.planning import Plan
from vasowave.study.figures.compared import planned_figure
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.fitted import plot_panel, save_panels
from vasowave.study.figures.loops import plot_loops
from vasowave.study.figures.predicted import predicted_figure, sensitivity_figure
from vasowave.study.figures.signals import draw_average, draw_cycle, draw_network, draw_raw


def register_all() -> None:
    """Register the body of every accessor."""
    Network.plot.register(draw_network)
    Recording.plot.register(draw_cycle)
    Recording.to_dataset.register(recording_dataset)
    RawRecording.plot.register(draw_raw)
    RawRecording.average.register(average_beats)
    EnsembleAverage.plot.register(draw_average)
    Model.simulate.register(simulate)
    VentricularFunction.plot.register(lambda function, ax=None: plot_loops(loops_dataset(function), ax))
    ModelEmulator.to_netcdf.register(write_emulator)
    UncertainModel.sensitivity.register(sensitivity_of)
    Sensitivity.figure.register(lambda indices: sensitivity_figure(indices.table))
    Plan.figure.register(planned_figure)
    Prediction.figure.register(
        lambda foretold: predicted_figure((foretold.before, foretold.after), foretold.root, foretold.label)
    )
    FitPlots.save.register(save_panels)
    FitPlots.draw.register(plot_panel)
    FitPlots.panels.register(lambda _: {name: panel.draw.__doc__ or panel.title for name, panel in PANELS.items()})
