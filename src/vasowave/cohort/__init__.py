"""Groups of animals: who belongs to which, described, compared, and the one of each that is shown."""

from vasowave.cohort.cohort import Cohort, gathered
from vasowave.cohort.comparison import SourceComparison, compare, importance
from vasowave.cohort.design import Design
from vasowave.cohort.pooling import pooled_mean, pooled_ratio
from vasowave.cohort.primary import Family, Primary, primary_comparison
from vasowave.cohort.table import cohort_table, describe
from vasowave.cohort.two_groups import contrasts, leave_one_out, pairwise_contrasts
from vasowave.cohort.variables import Variable

__all__ = [
    "Cohort",
    "Design",
    "Family",
    "Primary",
    "SourceComparison",
    "Variable",
    "cohort_table",
    "compare",
    "contrasts",
    "describe",
    "gathered",
    "importance",
    "leave_one_out",
    "pairwise_contrasts",
    "pooled_mean",
    "pooled_ratio",
    "primary_comparison",
]
