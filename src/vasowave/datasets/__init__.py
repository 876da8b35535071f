"""The published tables, their networks, and animals and lungs that the package makes itself."""

from vasowave.datasets.mouse import virtual_mouse
from vasowave.datasets.published import control_network, hypertensive_network, published_table

__all__ = ["control_network", "hypertensive_network", "published_table", "virtual_mouse"]
