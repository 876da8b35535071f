"""What every part stands on: errors, findings, settings, units, species, stored files, processes."""

from vasowave.base.accessors import Accessor as Accessor
from vasowave.base.descriptions import CLEAR_EVIDENCE_RATIO as CLEAR_EVIDENCE_RATIO
from vasowave.base.descriptions import BedLaw as BedLaw
from vasowave.base.descriptions import Law as Law
from vasowave.base.descriptions import Parameter as Parameter
from vasowave.base.descriptions import Quantity as Quantity
from vasowave.base.errors import InputError as InputError
from vasowave.base.errors import NumericalError as NumericalError
from vasowave.base.errors import VasowaveError as VasowaveError
from vasowave.base.errors import VasowaveWarning as VasowaveWarning
from vasowave.base.findings import KINDS as KINDS
from vasowave.base.findings import OTHER as OTHER
from vasowave.base.findings import Finding as Finding
from vasowave.base.findings import FindingKind as FindingKind
from vasowave.base.findings import Place as Place
from vasowave.base.findings import Severity as Severity
from vasowave.base.findings import as_json as as_json
from vasowave.base.findings import finding_of as finding_of
from vasowave.base.findings import from_json as from_json
from vasowave.base.findings import kind as kind
from vasowave.base.findings import shared as shared
from vasowave.base.findings import texts as texts
from vasowave.base.findings import warn as warn
from vasowave.base.settings import settings_of as settings_of
from vasowave.base.sites import PULMONARY as PULMONARY
from vasowave.base.sites import SITES as SITES
from vasowave.base.sites import SiteName as SiteName
from vasowave.base.sites import ranges_at as ranges_at
from vasowave.base.software import provenance as provenance
from vasowave.base.species import ANY_HEART_RATES as ANY_HEART_RATES
from vasowave.base.species import SPECIES as SPECIES
from vasowave.base.species import SpeciesName as SpeciesName
from vasowave.base.species import heart_rates_of as heart_rates_of
from vasowave.base.stores import LARGEST as LARGEST
from vasowave.base.stores import STORES as STORES
from vasowave.base.stores import parsed as parsed
from vasowave.base.stores import parsed_as as parsed_as
from vasowave.base.units import CANONICAL as CANONICAL
from vasowave.base.units import MMHG as MMHG
from vasowave.base.units import factor as factor
from vasowave.base.units import ratios as ratios

__all__: list[str]
