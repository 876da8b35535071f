"""What a reader of a cohort's report sees, as agreed: drawings, words, numbers; see approval.py."""

from approval import PAPER, approve, figure, figures, page, table, tree
from vasowave.study.figures import sheet_figure, svg


def test_approved_the_drawings_of_a_cohort(cohort_report):
    alike = tuple(f"fit-{number}" for number in range(2, 7))
    approve("cohort, figures", figures(cohort_report / "figures", without=alike), PAPER)


def test_approved_the_words_and_tables_of_a_cohort(cohort_report):
    names = ("report.html", "supplement.html")
    approve("cohort, pages", (line for name in names for line in page(cohort_report / name)))


def test_approved_the_tables_of_a_cohort_for_other_programs(cohort_report):
    paths = sorted((cohort_report / "tables").glob("*.csv"))
    approve("cohort, tables", (line for path in paths for line in table(path)), 1e-9)


def test_approved_the_results_of_an_animal(cohort_results):
    approve("animal, results", tree(cohort_results[0].to_datatree()), 1e-9)


def test_approved_a_sheet_of_fits(cohort_results):
    approve("sheet", figure("sheet", svg(sheet_figure(cohort_results, ["CTL", "HPH"]))), PAPER)
