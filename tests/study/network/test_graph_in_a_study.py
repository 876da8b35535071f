"""Networks whose vessels join again: their tables, their shares of the flow, their repairs, and what is refused."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.study.animal import network_dataset, network_of

TABLE = """name,from,to,length [mm],radius [mm]
main,heart,a,4.1,0.47
left,a,b,4.45,0.26
right,a,c,3.72,0.37
bridge,b,c,2.0,0.15
lung 1,b,bed 1,1.8,0.2
lung 2,c,bed 2,2.4,0.25
"""


@pytest.fixture
def circle(tmp_path):
    (tmp_path / "circle.csv").write_text(TABLE, "utf-8")
    return vw.read_network(tmp_path / "circle.csv")


def test_a_written_graph_and_a_stored_one_are_read_back_to_the_last_bit(circle, tmp_path):
    vw.write_network(circle, tmp_path / "again.csv")
    for back in (vw.read_network(tmp_path / "again.csv"), network_of(network_dataset(circle))):
        assert back.name == circle.name
        for field in ("nodes", "parent", "length", "radius"):
            assert np.array_equal(getattr(back, field), getattr(circle, field))
