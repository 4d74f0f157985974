"""What a reader gets: the wheel in an environment of its own, the sdist, the notebooks, the site in a browser."""

from __future__ import annotations

import importlib
import json
import os
import re
import shlex
import subprocess
import sys
import tarfile
import venv
from pathlib import Path

import pytest

from tests.docs.site import notebooks
from tests.sim.chromium import CHROMIUM, Browser

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = "\n".join(re.findall(r"^```python\n(.*?)^```$", README, re.MULTILINE | re.DOTALL))
COMMANDS = [line[2:] for line in README.splitlines() if line.startswith("$ shortfinal ")]
SITE = ROOT / "out" / "docs"


def reader(folder):
    """The environment of somebody who has nothing of this checkout on a path."""
    foreign = ("PYTHON", "PYTEST_", "SHORTFINAL", "VIRTUAL_ENV")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(foreign)}
    return kept | {"OPENBLAS_NUM_THREADS": "1", "XDG_CACHE_HOME": str(folder / ".cache")}


def called(call, folder, timeout=600, environment=None):
    """A finished command, in a folder."""
    call = [str(part) for part in call]
    environment = environment or reader(folder)
    return subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout)


def build(kind, folder):
    pytest.importorskip("hatchling")
    made = called([sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", folder], ROOT, 120)
    assert made.returncode == 0, made.stderr
    (file,) = folder.iterdir()
    return file


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Programs of an environment that holds the wheel, pandas, and what a notebook and a type checker need."""
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder / "environment", with_pip=True)
    programs = folder / "environment" / "bin"
    wheel = build("wheel", folder / "wheel")
    packages = [wheel, "pandas", "ipykernel", "mypy"]
    done = called([programs / "python", "-m", "pip", "install", "-q", *packages], folder, 900)
    if done.returncode:
        pytest.skip(f"the wheel's environment cannot be installed here: {done.stderr.strip().splitlines()[-1]}")
    return programs


@pytest.fixture
def empty(tmp_path):
    (tmp_path / "empty").mkdir()
    return tmp_path / "empty"


def left(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != ".cache")


def executed(notebook, programs, folder):
    """What a notebook gives that is run in a folder by the kernel of an environment: outputs of its cells."""
    kernel = folder.parent / "jupyter" / "kernels" / "reader"
    kernel.mkdir(parents=True)
    call = [str(programs / "python"), "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (kernel / "kernel.json").write_text(json.dumps({"argv": call, "display_name": "reader", "language": "python"}))
    (folder / "page.ipynb").write_text(json.dumps(notebook))
    options = ["--kernel_name=reader", "--timeout=600", "--inplace", "page.ipynb"]
    environment = {**reader(folder), "JUPYTER_PATH": str(kernel.parents[1])}
    call = [sys.executable, "-c", "import nbclient.cli; nbclient.cli.main()", *options]
    done = called(call, folder, environment=environment)
    assert done.returncode == 0, done.stderr[-3000:]
    made = json.loads((folder / "page.ipynb").read_text())
    (folder / "page.ipynb").unlink()
    code = [cell for cell in made["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))
    return [out for cell in code for out in cell["outputs"]]


def as_notebook(code):
    cell = {"cell_type": "code", "id": "code", "metadata": {}, "source": code, "outputs": [], "execution_count": None}
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": [cell]}


def test_the_python_of_the_readme_runs_in_a_notebook_from_the_wheel(installed, empty, row):
    pytest.importorskip("nbclient")
    told = executed(as_notebook(PYTHON + "\nprint(sim.__file__)\nresult"), installed, empty)
    text = "".join("".join(out.get("text", "")) for out in told)
    pages = ["".join(out["data"]["text/html"]) for out in told if out["output_type"] == "execute_result"]
    met = str(installed.parent) in text and left(empty) == ["out", "plan.png"] and "<svg" in "".join(pages)
    row("README: its Python in a notebook, from the wheel", "runs, without extras but pandas", "runs", met)
    assert met, text


def test_a_strict_type_checker_finds_no_any_in_the_python_of_the_readme(installed, empty, row):
    revealed = [*re.findall(r"\bsim\.\w+(?=\()", PYTHON), "result", "result.flight", "again"]
    shown = "\n".join(f"reveal_type({name})" for name in revealed)
    (empty / "readme.py").write_text(f"{PYTHON}\n{shown}\n")
    done = called([installed / "python", "-m", "mypy", "--strict", "readme.py"], empty)
    kinds = re.findall(r'Revealed type is "(.*)"', done.stdout)
    gives = [kind.rpartition("-> ")[2] for kind in kinds]
    met = done.returncode == 0 and len(kinds) == len(revealed) and "Any" not in gives
    row("README: mypy --strict on its Python, from the wheel", "no error, no Any", f"{len(kinds)} types", met)
    assert met, done.stdout + done.stderr


def test_the_commands_of_the_readme_run_from_the_wheel_in_an_empty_folder(installed, empty, row):
    failed = []
    for command in COMMANDS:
        done = called([installed / "shortfinal", *shlex.split(command, comments=True)[1:]], empty)
        if done.returncode or done.stderr:
            failed.append(f"{command}: {done.stdout[-500:]}{done.stderr}")
    ran = len(COMMANDS) - len(failed)
    row("README: its commands from the wheel", "run in an empty folder", f"{ran} of {len(COMMANDS)}", not failed)
    assert not failed
    assert {"out", "mine.toml"} <= set(left(empty))


def test_the_tests_of_the_sdist_pass(tmp_path, row):
    with tarfile.open(build("sdist", tmp_path / "sdist")) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    call = [sys.executable, "-m", "pytest", "-n", "2", "-m", "not acceptance and not soak"]
    done = called(call, source, 1200)
    row("sdist: its own tests", "pass", done.stdout.strip().splitlines()[-1], done.returncode == 0)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]


@pytest.mark.parametrize("name", sorted(notebooks.every()))
def test_a_notebook_of_the_tutorials_runs(name, tmp_path, row):
    """Of a tutorial's page the same code is run by `make test`; here the notebook itself, by a kernel."""
    pytest.importorskip("nbclient")
    made = notebooks.notebook(notebooks.TUTORIALS / name.replace(".ipynb", ".md"))
    (tmp_path / "empty").mkdir()
    executed(made, Path(sys.executable).parent, tmp_path / "empty")
    row(f"tutorial {name}", "runs as a notebook", "runs", True)


@pytest.fixture(scope="module")
def site():
    if importlib.util.find_spec("zensical") is None:
        pytest.skip("zensical is not installed: pip install '.[docs]'")
    for call in ("tests.docs.site.assemble",), ("zensical", "build", "--clean", "--strict"):
        done = subprocess.run([sys.executable, "-m", *call], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_site_is_built_without_a_warning(site, row):
    pages = sorted(SITE.rglob("*.html"))
    met = "No issues found" in site and "griffe" not in site
    row("site: strict build", "no warnings", f"{len(pages)} pages, no issues" if met else site[-300:], met)
    assert met


def test_the_site_names_nothing_that_would_be_fetched_from_elsewhere(site):
    tags = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*(?:src|href)=[\"']?https?://")
    for file in SITE.rglob("*.html"):
        assert tags.findall(file.read_text(encoding="utf-8")) == [], file
    for file in SITE.rglob("*.css"):
        assert re.findall(r"(?:url\(|@import)\s*[\"']?https?://", file.read_text(encoding="utf-8")) == [], file


def test_a_browser_of_the_site_fetches_nothing_from_elsewhere(site, tmp_path, row):
    """Every page of the documents opened by a browser; pages of sources are all of one make, so one stands for them."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on the PATH, so the site was not looked at")
    pages = [page for page in sorted(SITE.rglob("*.html")) if "source" not in page.relative_to(SITE).parts[:1]]
    pages += sorted((SITE / "source").rglob("*.html"))[:1]
    browser = Browser(tmp_path / "browser")
    try:
        for page in pages:
            browser.open(page)
        elsewhere = [url for url in browser.fetched if not url.startswith(("file:", "data:", "blob:"))]
        said = [line for line in browser.said if "file:" not in json.dumps(line)]
    finally:
        browser.close()
    row(
        "site: what a browser fetches for its pages",
        "nothing from elsewhere",
        f"{len(browser.fetched)} files of {len(pages)} pages, {len(elsewhere)} from elsewhere",
        not elsewhere,
    )
    assert not elsewhere
    assert not said
