"""Approved descriptions can fail: each part of a look is seen, and a last digit is not."""

import io

import pytest
from matplotlib.figure import Figure

import approval


def drawn(**look):
    chosen = {"color": "#00a7c4", "linewidth": 1.0, "marker": ""} | look
    figure = Figure()
    figure.subplots().plot([0, 1, 2], [0, 3, 1], **chosen)
    text = io.StringIO()
    figure.savefig(text, format="svg")
    return list(approval.figure("it", text.getvalue()))


@pytest.mark.parametrize("look", [{"color": "#00a7c5"}, {"linewidth": 1.1}, {"marker": "o"}, {"linestyle": "--"}])
def test_another_look_is_another_description(look):
    assert drawn() == drawn()
    assert drawn(**look) != drawn()


def test_words_must_agree_and_numbers_nearly(tmp_path, monkeypatch):
    monkeypatch.setattr(approval, "APPROVED", tmp_path)
    monkeypatch.delenv("VASOWAVE_APPROVE", raising=False)
    (tmp_path / "it.txt").write_text("line #00a7c4 at 12.5000\nmean 1e-5 of 2048\n")
    approval.approve("it", ["line #00a7c4 at 12.5001", "mean 1.0001e-5 of 2048"])
    approval.approve("it", ["line #00a7c4 at 12.51", "mean 1e-5 of 2048"], absolute=0.02)
    assert approval.alike("x 392.04..496.48", "x 392.04..496.49", 0.0, 1e-4)
    assert not approval.alike("x 392.04..496.48", "x 392.04..497.48", 0.0, 1e-4)
    array = "radial: 78 of 78, -0.37347 88.422 12.505 28.711"
    assert approval.alike(array, "radial: 78 of 78, -0.37783 88.427 12.504 28.71", 0.0, 1e-2)
    for other in ("-1.4 88.422 12.505 28.711", "-0.37347 89.5 12.505 28.711", "-0.37347 88.422 12.9 28.711"):
        assert not approval.alike(array, f"radial: 78 of 78, {other}", 0.0, 1e-2)
    for changed in (
        ["line #00a7c4 at 12.6", "mean 1e-5 of 2048"],
        ["line #00a7c5 at 12.5", "mean 1e-5 of 2048"],
        ["line #00a7c4 at 12.5", "mean 1e-5 of 2049"],
        ["line #00a7c4 at 12.5"],
        ["line #00a7c4 at 12.5", "mean 1e-5 of 2048", "more"],
    ):
        with pytest.raises(AssertionError, match="VASOWAVE_APPROVE=1"):
            approval.approve("it", changed)
