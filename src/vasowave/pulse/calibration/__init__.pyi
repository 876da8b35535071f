"""Fit a model to a recording: parameters and bounds, objective, many starts, and what the data determine."""

from vasowave.pulse.calibration.compared import compared_part as compared_part
from vasowave.pulse.calibration.compared import sites_of as sites_of
from vasowave.pulse.calibration.coordinates import Coordinates as Coordinates
from vasowave.pulse.calibration.descent import descend as descend
from vasowave.pulse.calibration.fitting import Fitting as Fitting
from vasowave.pulse.calibration.fitting import Search as Search
from vasowave.pulse.calibration.fitting import calibrate as calibrate
from vasowave.pulse.calibration.generalized import least_squares_optimum as least_squares_optimum
from vasowave.pulse.calibration.generalized import reoptimize as reoptimize
from vasowave.pulse.calibration.linear_tree import linear_spectra as linear_spectra
from vasowave.pulse.calibration.linear_tree import spanning_tree as spanning_tree
from vasowave.pulse.calibration.linear_tree import spectrum_of as spectrum_of
from vasowave.pulse.calibration.objective import Objective as Objective
from vasowave.pulse.calibration.optimization import ROUGH_TOLERANCE as ROUGH_TOLERANCE
from vasowave.pulse.calibration.optimization import SearchEnd as SearchEnd
from vasowave.pulse.calibration.optimization import search as search
from vasowave.pulse.calibration.parameters import ParameterLimits as ParameterLimits
from vasowave.pulse.calibration.parameters import fitted_parameters as fitted_parameters
from vasowave.pulse.calibration.parameters import parameter_space as parameter_space
from vasowave.pulse.calibration.profile import profile_likelihood as profile_likelihood
from vasowave.pulse.calibration.result import CalibratedModel as CalibratedModel
from vasowave.pulse.calibration.sites import POINT_HARMONIC as POINT_HARMONIC
from vasowave.pulse.calibration.starts import DERIVATIVE_ERROR as DERIVATIVE_ERROR
from vasowave.pulse.calibration.starts import NOT_KEPT as NOT_KEPT
from vasowave.pulse.calibration.starts import STAGE as STAGE
from vasowave.pulse.calibration.starts import SearchCache as SearchCache
from vasowave.pulse.calibration.surrogate import CorrectedNetwork as CorrectedNetwork
from vasowave.pulse.calibration.surrogate import linear_optimum as linear_optimum
from vasowave.pulse.calibration.uncertainty import UNDETERMINED as UNDETERMINED
from vasowave.pulse.calibration.uncertainty import ParameterSpread as ParameterSpread
from vasowave.pulse.calibration.uncertainty import fit_findings as fit_findings
from vasowave.pulse.calibration.uncertainty import parameter_table as parameter_table
from vasowave.pulse.calibration.valleys import Misled as Misled
from vasowave.pulse.calibration.valleys import ValleyRules as ValleyRules
from vasowave.pulse.calibration.valleys import Valleys as Valleys

__all__: list[str]
