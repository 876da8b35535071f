"""The published tables, their networks, and animals and lungs that the package makes itself."""

from vasowave.study.datasets.virtual import VirtualAnimal as VirtualAnimal
from vasowave.study.datasets.virtual import virtual_cohort as virtual_cohort
from vasowave.study.datasets.virtual_files import write_lab_files as write_lab_files
from vasowave.study.datasets.virtual_files import write_virtual_cohort as write_virtual_cohort

__all__: list[str]
