"""What looks wrong with a network, or is not known of it, in sentences."""

import numpy as np

from vasowave.network import Network


def implausible_sizes(network: Network) -> list[str]:
    """Return a sentence for every sign that lengths or radii are in another unit than cm."""
    remarks = []
    ratio = float(np.median(network.length / network.radius))
    if not 1.5 <= ratio <= 150:
        remarks.append(
            f"vessels are {ratio:.2g} radii long (median); arteries are 3 to 100: is the radius "
            "in the same unit as the length, and is it a radius, not a diameter?"
        )
    widest = float(network.radius[network.root])
    if not 0.004 <= widest <= 2.0:
        remarks.append(
            f"the root's radius is {widest:.3g} cm; a mouse's main pulmonary artery has 0.05 cm, "
            "a human aorta 1.5 cm: is the unit in the header right?"
        )
    return remarks


def unknown_pressure(network: Network) -> list[str]:
    """Return a sentence if the pressure at which the radii were measured is not known."""
    if network.pressure:
        return []
    return [
        "The pressure at which the vessels were imaged is not known; their radii are taken for those at zero pressure. "
        "If they were filled, the wall seems stiffer and waves faster than they are, and how it stiffens cannot be "
        "told. Give it as a column 'pressure [mmHg]' of the network's file, or as Network(..., pressure=...)."
    ]
