"""What a person at the terminal is told of a fit, as agreed; see approval.py."""

from approval import approve
from vasowave.base import OTHER
from vasowave.study.running import fit_sentences


def test_approved_what_is_told_of_a_fit_at_the_terminal(cohort_results):
    said = [fit_sentences(one, (OTHER(text="the zero is doubtful"),)) for one in cohort_results[:3]]
    assert said[0][0] == "warning: the zero is doubtful"
    assert any(one.endswith("the flow <ends> late & is odd") for one in said[2])
    approve("told of a fit", (line for one in said for line in one))
