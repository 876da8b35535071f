"""What nobody can read is refused in the same words, whoever asks."""

import pytest

from vasowave.base import InputError
from vasowave.catheter.read import describe_recording
from vasowave.study.folder import StudyFile
from vasowave.study.results import load_recording
from vasowave.study.running import one_row

UNREADABLE = {
    "words": b"an essay, of a few words\nand, a second line\nthat is, no table\n",
    "ragged": b"time [s],pressure [mmHg],flow [ml/s]\n0,15,0.1\n0.001,15\n0.002,15.1,0.1\n",
    "no numbers": b"time [s],pressure [mmHg],flow [ml/s]\nnull,null,null\nnull,null,null\n",
    "a cell of text": b"time [s],pressure [mmHg],flow [ml/s]\n0,15,0.1\n0.001,off,0.1\n0.002,15.1,0.1\n",
}


def sentence(read):
    with pytest.raises(InputError) as caught:
        read()
    return str(caught.value)


@pytest.mark.parametrize("name", UNREADABLE)
def test_adding_and_fitting_say_the_same_of_a_file(tmp_path, name):
    path = tmp_path / "a.csv"
    path.write_bytes(UNREADABLE[name])
    row = one_row(None, [path], "a", "a", {})
    assert sentence(lambda: load_recording(row, StudyFile())) == sentence(lambda: describe_recording(path))
