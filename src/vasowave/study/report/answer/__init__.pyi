"""The one result on the first page: an answer to each question, one forest plot, what is not known, what is wrong."""

from vasowave.study.report.answer.animal import animal_answers as animal_answers
from vasowave.study.report.answer.attribution import attribution_answer as attribution_answer
from vasowave.study.report.answer.attribution import attribution_summary as attribution_summary
from vasowave.study.report.answer.changes import change_table as change_table
from vasowave.study.report.answer.design import design_text as design_text
from vasowave.study.report.answer.effects import Crossing as Crossing
from vasowave.study.report.answer.effects import where as where
from vasowave.study.report.answer.forest import animals_of as animals_of
from vasowave.study.report.answer.forest import group_rows as group_rows
from vasowave.study.report.answer.groups import by_fits as by_fits
from vasowave.study.report.answer.groups import group_answer as group_answer
from vasowave.study.report.answer.groups import influence as influence
from vasowave.study.report.answer.groups import not_told as not_told
from vasowave.study.report.answer.groups import other_laws as other_laws
from vasowave.study.report.answer.limits import assumed_errors as assumed_errors
from vasowave.study.report.answer.limits import model_limits as model_limits
from vasowave.study.report.answer.limits import shared_images as shared_images
from vasowave.study.report.answer.marks import Marks as Marks
from vasowave.study.report.answer.page import answer_sections as answer_sections
from vasowave.study.report.answer.page import decay as decay
from vasowave.study.report.answer.problem_list import problem_blocks as problem_blocks
from vasowave.study.report.answer.problem_list import problems as problems
from vasowave.study.report.answer.walls import wall_answer as wall_answer

__all__: list[str]
