"""The checks of a release, where they cost nothing; `tools/release.py` runs them all."""

import pytest

import release


@pytest.mark.parametrize(
    "words",
    ["GPL-3.0-or-later", "LGPLv2+", "GNU General Public License v3", "BSD-3-Clause AND GPL-2.0-only", "AGPL-3.0"],
)
def test_a_license_that_binds_is_found_in_all_its_spellings(words):
    assert release.BINDING.search(words)


@pytest.mark.parametrize(
    "words",
    [
        "BSD-3-Clause AND GPL-3.0-or-later WITH GCC-exception-3.1",
        "Apache-2.0 WITH LLVM-exception",
        "MIT-CMU",
        "PSF-2.0",
    ],
)
def test_a_license_that_binds_nobody_is_let_through(words):
    assert release.FREE.search(words)
    assert not release.BINDING.search(words)


def test_files_that_name_different_versions_are_named(tmp_path):
    (tmp_path / "recipe").mkdir()
    (tmp_path / "pyproject.toml").write_text('[project]\nversion = "1.2.0"\nurls = {}\n', "utf-8")
    (tmp_path / "CITATION.cff").write_text("version: 1.2.0\n", "utf-8")
    (tmp_path / "recipe" / "recipe.yaml").write_text('context:\n  version: "1.3.0"\n', "utf-8")
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## [1.1.0] - 2026-01-31\n", "utf-8")
    recipe, changelog = release.named_versions(tmp_path)
    assert recipe.startswith("recipe/recipe.yaml says 1.3.0, pyproject.toml 1.2.0")
    assert changelog.startswith("CHANGELOG.md says 1.1.0")
