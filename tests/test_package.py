"""What `import vasowave` offers."""

import subprocess
import sys

import pytest

import vasowave


@pytest.mark.parametrize("name", vasowave.__all__)
def test_every_public_name_exists_and_is_documented(name):
    assert getattr(vasowave, name).__doc__


def test_an_unknown_name_is_an_attribute_error_that_lists_the_known_ones():
    with pytest.raises(AttributeError, match="calibrate"):
        _ = vasowave.fit_everything


def test_importing_the_package_loads_nothing_heavy():
    code = "import sys, vasowave; print(sorted({'numpy', 'numba', 'pandas', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
