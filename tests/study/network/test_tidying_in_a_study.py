import numpy as np
from typer.testing import CliRunner

import vasowave as vw
from vasowave.base import InputError
from vasowave.cli import app
from vasowave.pulse.model import estimate_nominal


def test_a_tree_of_a_micrometer_vessel_is_repaired_by_the_command_and_then_simulated(tmp_path):
    rows = ["name,parent,length [cm],radius [cm]", "main,,0.4,0.05", "stub,main,0.00014,0.04", "left,stub,0.4,0.03",
            "right,stub,0.3,0.03", "other,main,0.3,0.03", ""]  # fmt: skip
    (tmp_path / "tree.csv").write_text("\n".join(rows), "utf-8")
    said = CliRunner().invoke(app, ["tidy", str(tmp_path / "tree.csv"), "-o", str(tmp_path / "tidied.csv")])
    assert said.exit_code == 0, said.output
    assert "merged: 'stub' (0.00014 cm long" in said.output
    over = CliRunner().invoke(app, ["tidy", str(tmp_path / "tree.csv"), "-o", str(tmp_path / "tree.csv")])
    assert isinstance(over.exception, InputError)  # what it reads is never overwritten
    network, mouse = vw.read_network(tmp_path / "tidied.csv"), vw.virtual_mouse()
    assert network.name == ("main", "left", "right", "other")
    beds = estimate_nominal(network, mouse).outlets
    assert np.isfinite(vw.simulate(vw.Model(network, vw.LinearWall(60.0), beds), mouse)["pressure"]).all()
