"""Faces of packages: what a stub names is what the package gives, and nothing is loaded before it is asked for."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import vasowave

ROOT = Path(vasowave.__file__).parent
STUBS = sorted(ROOT.rglob("*/__init__.pyi"))
ABOVE = {stub.relative_to(ROOT).parts[0] for stub in STUBS}


@pytest.mark.parametrize("stub", STUBS, ids=lambda stub: ".".join(stub.parent.relative_to(ROOT).parts))
def test_every_name_of_a_stub_is_the_object_of_its_module(stub):
    package = import_module(".".join(("vasowave", *stub.parent.relative_to(ROOT).parts)))
    lines = [line for line in ast.parse(stub.read_text("utf-8")).body if isinstance(line, ast.ImportFrom)]
    names = {name.name: line.module for line in lines for name in line.names}
    assert dir(package) == sorted(names)
    for name, module in names.items():
        assert getattr(package, name) is getattr(import_module(module), name)


def test_a_name_that_a_package_lacks_is_an_attribute_error_with_the_nearest_name_or_all():
    base = import_module("vasowave.base")
    with pytest.raises(AttributeError, match=r"'vasowave.base' has no attribute 'factr' \(did you mean 'factor'"):
        _ = base.factr
    with pytest.raises(AttributeError, match=r"'vasowave.base' has no attribute 'zzz'; dir\(vasowave.base\) lists"):
        _ = base.zzz


def test_importing_a_package_loads_none_of_its_modules():
    code = "import sys, vasowave.base; print([name for name in sys.modules if name.startswith('vasowave.base.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(ast.literal_eval(done.stdout)) == {"vasowave.base.accessors", "vasowave.base.faces"}
