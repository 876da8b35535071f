"""What a fit says where a lab knows image, wall, probe and zero exactly."""

import vasowave as vw
from vasowave.pulse.model import identity
from vasowave.study.animal import result_of

EXACT = dict.fromkeys(("radius_scale_sd", "length_scale_sd", "k_sd", "taper_sd", "flow_gain_sd", "zero_sd"), 0.0)


def summary_without_errors(fit):
    """Return `Fit.summary` of the recording's own errors alone."""
    law, beds = identity(type(fit.model.wall)), identity(type(fit.model.outlets))
    settings = vw.Settings(walls=(law,), beds=beds, starts=len(fit.starts), blood=fit.model.blood, **EXACT)
    animal = vw.Animal("animal", "animal", fit.model.network, fit.recording)
    return result_of(animal, [fit], settings).laws[fit.wall].summary()
