"""Tables of sites and the waveforms that they name."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.errors import InputError


def written(folder, text, **files):
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content)
    (folder / "sites.csv").write_text(text)
    return folder / "sites.csv"


def test_numbers_and_waveforms_are_read_in_the_unit_of_the_table(tmp_path):
    t = np.arange(41) / 400
    rows = "\n".join(f"{a:.4f},{1 + np.sin(2 * np.pi * a / 0.1):.6f}" for a in t)  # the last repeats the first
    path = written(
        tmp_path,
        "quantity,vessel,place [mm],file,mean,unit,error,zero sd,gain sd\n"
        "pressure,LPA,2,wave.csv,,kPa,0.01,0.1,\nflow,RPA,,,80,ul/s,8,,0.1\n",
        wave=f"time [s],pressure [kPa]\n{rows}\n",
    )
    one, other = vw.read_sites(path)
    assert (one.quantity, one.vessel, one.cm, len(one.waveform)) == ("pressure", "LPA", 0.2, 40)
    assert one.period == pytest.approx(0.1)
    assert one.waveform.mean() == pytest.approx(7.50062, rel=1e-5)
    assert (one.error, one.zero_sd) == (pytest.approx(0.0750062, rel=1e-5), pytest.approx(0.750062, rel=1e-5))
    assert (other.place, other.mean, other.error, other.gain) == (0.5, pytest.approx(0.08), pytest.approx(0.008), 0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("quantity,vessel,unit,error,men\nflow,a,ml/s,1,2\n", "unknown column 'men' .did you mean 'mean'"),
        ("quantity,vessel,unit\nflow,a,ml/s\n", "no column 'error'"),
        ("quantity,vessel,unit,error,mean\nflw,a,ml/s,1,2\n", "line 2: 'flw' cannot be observed"),
        ("quantity,vessel,unit,error,mean\nflow,a,mmHg,1,2\n", "line 2: 'mmHg' is not a unit of flow"),
        ("quantity,vessel,unit,error,mean\nflow,a,ml/s,x,2\n", "line 2: column 'error': 'x' is not a number"),
        ("quantity,vessel,unit,error,mean\nflow,a,ml/s,,2\n", "line 2: the cell 'error' is empty"),
        ("quantity,vessel,unit,error,file\nflow,a,ml/s,1,no.csv\n", "line 2: there is no file"),
        ("quantity,vessel,unit,error,file\nflow,a,ul/s,1,wave.csv\n", "its header says ml/s, the table of sites says"),
        ("quantity,vessel,unit,error\nflow,a,ml/s,1\n", "give a waveform, or at least one of mean"),
        ("quantity,vessel,place,unit,error,mean\nflow,a,1.5,ml/s,1,2\n", "lies outside the vessel"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    wave = "\n".join(["flow [ml/s]", *map(str, np.sin(np.arange(64) / 10))])
    with pytest.raises(InputError, match=message):
        vw.read_sites(written(tmp_path, text, wave=wave + "\n"))
