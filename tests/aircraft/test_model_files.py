"""Judge: an attacker. A model must not reach out of its private root."""

import os
import socket
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from aircraft import model_files, safe_xml
from aircraft.airframe import load
from aircraft.model_files import ModelError, available, private_root, read


@pytest.fixture
def folder(tmp_path):
    """Writes a model of the user and returns its folder."""

    def write(body, name="mine", encoding="utf-8"):
        home = tmp_path / name
        home.mkdir(exist_ok=True)
        (home / f"{name}.xml").write_bytes(body.encode(encoding))
        return home

    return write


def own(text=""):
    """The An-26 under the user's name, with something put in front of its end."""
    source = (model_files.OWN_MODELS / "an26" / "an26.xml").read_text()
    return source.replace("</fdm_config>", f"{text}</fdm_config>")


def test_every_model_that_is_listed_has_its_file():
    names = available()
    assert names["an26"] == "own model"
    assert {"c172x", "A320", "737", "B747"} <= set(names)
    for name in names:
        assert (model_files.folder(name) / f"{name}.xml").is_file()


def test_a_users_folder_flies_like_our_own(folder):
    assert load(folder(own())).mass == pytest.approx(20000.0, rel=1e-6)


@pytest.mark.parametrize(
    "device",
    [
        '<output name="OUT" type="CSV" rate="10"><rates>ON</rates></output>',
        '<output name="localhost" type="SOCKET" port="PORT" protocol="UDP" rate="10"><rates>ON</rates></output>',
        '<output file="other"/>',
        '<input port="PORT"/>',
        '<system name="x"><channel name="y"><input port="PORT"/></channel></system>',
        '<system name="x"><channel name="y"><output name="OUT" type="CSV"><rates/></output></channel></system>',
    ],
)
def test_devices_are_dropped_at_any_depth(folder, tmp_path, device):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("localhost", 0))
        listener.setblocking(False)
        port = listener.getsockname()[1]
        text = device.replace("OUT", str(tmp_path / "out.csv")).replace("PORT", str(port))
        model = read(folder(own(text)))
        for element in model.root.iter():
            assert element.tag not in ("input", "output") or not (element.attrib or len(element))
        airframe = load(tmp_path / "mine")
        airframe._executive.run_ic()
        airframe._executive.run()
        with pytest.raises(BlockingIOError):
            listener.recv(1)
    assert not (tmp_path / "out.csv").exists()


def test_control_systems_keep_the_inputs_that_only_name_a_property():
    assert [element for element in read("an26").root.iter("input") if element.text]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (own()[:2000], "not well-formed"),
        ("", "not well-formed"),
        ("<other/>", "its root is <other>"),
        ('<!DOCTYPE fdm_config [<!ENTITY x SYSTEM "file:///etc/passwd">]><fdm_config/>', "DOCTYPE"),
        (own('<system file="../../secret"/>'), "leaves the folder"),
        (own('<system file="/etc/passwd"/>'), "leaves the folder"),
        (own('<system file="C:\\secret"/>'), "leaves the folder"),
        (own('<system file="nowhere"/>'), "does not exist"),
        (own("<system><property>simulation/write-state-file</property></system>"), "steers the simulator"),
        (own().replace("<axis", "<no-axis>", 1), "not well-formed"),
        ("<fdm_config/>", "JSBSim cannot load|no complete"),
        (own().replace(">20000<", ">heavy<"), "<emptywt> must be a number in KG, LBS, SLUG, not 'heavy' KG"),
        (own().replace('<emptywt unit="KG">', '<emptywt unit="STONE">'), "must be a number in KG, LBS, SLUG"),
        (own().replace("<emptywt", "<nothing").replace("/emptywt", "/nothing"), "no complete <mass_balance>"),
        (own().replace("<y>-3.95</y>", "", 1), "must have x, y and z"),
    ],
)
def test_what_may_not_be_loaded_gets_one_sentence(folder, body, message):
    with pytest.raises(ModelError, match=message) as caught:
        load(folder(body))
    assert "\n" not in str(caught.value)


def test_wrong_encoding_gets_one_sentence(folder):
    with pytest.raises(ModelError, match=r"not well-formed|cannot be read"):
        read(folder(own("<!-- \xe9t\xe9 -->"), encoding="latin-1"))


def test_sections_may_stand_in_files_of_their_own(folder):
    whole = ElementTree.fromstring(own())
    balance = whole.find("mass_balance")
    whole[list(whole).index(balance)] = ElementTree.Element("mass_balance", file="weights")
    home = folder(ElementTree.tostring(whole, encoding="unicode"))
    with pytest.raises(ModelError, match=r"weights.xml', which does not exist"):
        load(home)
    (home / "weights.xml").write_text(ElementTree.tostring(balance, encoding="unicode"))
    assert load(home, 21000.0).mass == pytest.approx(21000.0, rel=1e-6)


def test_links_and_large_files_are_refused(folder, tmp_path):
    secret = tmp_path / "secret.xml"
    secret.write_text("<system/>")
    home = folder(own('<system file="inside"/>'))
    (home / "inside.xml").symlink_to(secret)
    with pytest.raises(ModelError, match="link"):
        read(home)
    with pytest.raises(ModelError, match="larger than"):
        read(folder("<fdm_config>" + " " * safe_xml.LARGEST_FILE + "</fdm_config>"))


@pytest.mark.parametrize(("name", "near"), [("an62", "an26"), ("c172", "c172"), ("A32", "A320")])
def test_an_unknown_name_gets_the_nearest_ones(name, near):
    with pytest.raises(ModelError, match=f"did you mean .*{near}"):
        read(name)


@pytest.mark.parametrize("name", ["", "..", ".", "zzzzzzzz"])
def test_an_unlikely_name_gets_the_list(name):
    with pytest.raises(ModelError, match=r"known are|did you mean|no aircraft"):
        read(name)


def test_nothing_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    with private_root(read("c172x")) as root:
        assert root.is_relative_to(tmp_path)
        assert not [path for path in root.rglob("*") if path.is_symlink() or "script" in path.name]
    airframe = load("c172x")
    airframe._executive.run_ic()
    airframe._executive.run()
    assert os.listdir(tmp_path) == []


def test_nothing_is_printed(capfd):
    load("c172x")
    with pytest.raises(ModelError):
        load(Path("nowhere/at_all"))
    assert capfd.readouterr() == ("", "")
