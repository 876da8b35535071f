"""Outlets that cannot be are refused by the name of their vessel."""

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.model.outlets import ImpedanceSpectrum


@pytest.mark.parametrize(("harmonic", "value"), [(0, 0.0), (1, np.nan), (2, -1.0)])
def test_the_one_vessel_whose_impedance_cannot_be_is_named(harmonic, value):
    spectrum = np.full((3, 2), 100.0 + 0j)
    assert ImpedanceSpectrum(spectrum).checked(("a", "b"))
    spectrum[harmonic, 1] = value
    with pytest.raises(InputError, match="vessel 'b': its impedance is not finite, or its resistance is not positive"):
        ImpedanceSpectrum(spectrum).checked(("a", "b"))
    with pytest.raises(InputError, match=r"has shape \(3, 2\); it must be \(harmonics, 3\)"):
        ImpedanceSpectrum(spectrum).checked(("a", "b", "c"))
