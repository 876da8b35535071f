"""What a recording says about an animal when geometry and model are uncertain too: the posterior."""

from vasowave.inference.known_errors import KnownErrors
from vasowave.inference.laws import compare_laws
from vasowave.inference.posterior import Sampling, posterior
from vasowave.inference.priors import Priors
from vasowave.inference.result import Diagnostics, Posterior

__all__ = ["Diagnostics", "KnownErrors", "Posterior", "Priors", "Sampling", "compare_laws", "posterior"]
