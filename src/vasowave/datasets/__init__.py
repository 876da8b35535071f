"""What ships with the package: the paper's published tables, and a virtual mouse made from them."""

from vasowave.datasets.published import control_network, hypertensive_network, published_table

__all__ = ["control_network", "hypertensive_network", "published_table"]
