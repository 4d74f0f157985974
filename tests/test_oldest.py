"""The lowest versions are read off pyproject.toml, so that `make test-oldest` tries what it allows and nothing else."""

from __future__ import annotations

import re

import pytest

from tests.oldest import PROJECT, lowest


def test_every_requirement_is_held_at_its_lowest_version():
    text = PROJECT.read_text(encoding="utf-8")
    found = lowest(text)
    assert found["numpy"] == re.search(r'"numpy >= ([\d.]+)"', text)[1]
    assert {"jsbsim", "scipy", "control", "typer", "pytest", "distributed", "pyarrow"} <= set(found)
    tried = re.sub(r"^docs = \[.*?^\]\n", "", text, flags=re.MULTILINE | re.DOTALL)  # those only build the documents
    assert len(found) == len(set(re.findall(r'^  "([\w-]+) >= ', tried, re.MULTILINE)))


def test_a_requirement_without_a_lowest_version_is_refused():
    with pytest.raises(ValueError, match="'numpy' must be written as NAME >= VERSION"):
        lowest('[project]\ndependencies = ["numpy"]\n[project.optional-dependencies]\ndev = []\n')
