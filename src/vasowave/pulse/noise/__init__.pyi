"""What the residual of a fit says about its noise: spectra, kernels, ARMA processes, and their likelihood."""

from vasowave.pulse.noise.arma import Arma as Arma
from vasowave.pulse.noise.arma import autocovariance as autocovariance
from vasowave.pulse.noise.arma import concentrated as concentrated
from vasowave.pulse.noise.arma import fit_arma as fit_arma
from vasowave.pulse.noise.fitting import NOISE as NOISE
from vasowave.pulse.noise.fitting import OF_PAPER as OF_PAPER
from vasowave.pulse.noise.fitting import fit_noise as fit_noise
from vasowave.pulse.noise.likelihood import FAMILIES as FAMILIES
from vasowave.pulse.noise.likelihood import KERNELS as KERNELS
from vasowave.pulse.noise.likelihood import Independent as Independent
from vasowave.pulse.noise.likelihood import Kernel as Kernel
from vasowave.pulse.noise.likelihood import PeriodicStationary as PeriodicStationary
from vasowave.pulse.noise.likelihood import fit_kernel as fit_kernel
from vasowave.pulse.noise.likelihood import matern32 as matern32
from vasowave.pulse.noise.likelihood import matern52 as matern52
from vasowave.pulse.noise.likelihood import maximize as maximize
from vasowave.pulse.noise.likelihood import neural_network as neural_network
from vasowave.pulse.noise.likelihood import periodic as periodic
from vasowave.pulse.noise.likelihood import regularize as regularize
from vasowave.pulse.noise.likelihood import squared_exponential as squared_exponential
from vasowave.pulse.noise.models import CirculantNoise as CirculantNoise
from vasowave.pulse.noise.models import DenseNoise as DenseNoise
from vasowave.pulse.noise.models import Noise as Noise
from vasowave.pulse.noise.models import log_likelihood as log_likelihood
from vasowave.pulse.noise.models import whiten as whiten
from vasowave.pulse.noise.spectrum import LOG_POWER_PRIOR as LOG_POWER_PRIOR
from vasowave.pulse.noise.spectrum import LOG_RATE_PRIOR as LOG_RATE_PRIOR
from vasowave.pulse.noise.spectrum import SIZE_PRIOR as SIZE_PRIOR
from vasowave.pulse.noise.spectrum import Beside as Beside
from vasowave.pulse.noise.spectrum import Spectra as Spectra
from vasowave.pulse.noise.spectrum import falling_power as falling_power
from vasowave.pulse.noise.spectrum import fourier as fourier
from vasowave.pulse.noise.spectrum import harmonics as harmonics
from vasowave.pulse.noise.spectrum import least_squares_covariance as least_squares_covariance
from vasowave.pulse.noise.spectrum import likely_spectra as likely_spectra
from vasowave.pulse.noise.spectrum import restricted_likelihood as restricted_likelihood

__all__: list[str]
