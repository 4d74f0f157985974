"""Models that somebody hostile, or only careless, could hand over: one entry each, and what must be said of it.

``TARGET`` in a text is a folder that none of them may reach.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from aircraft.model_files import OWN_MODELS

GOOD = (OWN_MODELS / "an26" / "an26.xml").read_text()
FLIES = "flies"
ODD_NAME = "ein flugzeug & <co> $_{ \u202e"
REVERSE_DELAY = '<actuator name="a"><input>velocities/vt-fps</input><delay type="time">-5</delay></actuator>'


class HostileModel(NamedTuple):
    """A folder of a model: what is in its file, what beside it, and what is said of it."""

    said: str  # a regular expression; FLIES = what is hostile is dropped and the rest is flown
    text: str | bytes
    beside: dict[str, str | bytes] = {}  # noqa: RUF012 (a NamedTuple's default is never changed)
    then: Callable[[Path], None] | None = None  # what is done to the folder

    def write(self, home: Path, target: Path) -> Path:
        """Make the folder; returns what a scenario names."""
        home.mkdir(parents=True)
        for name, content in {f"{home.name}.xml": self.text, **self.beside}.items():
            raw = content if isinstance(content, bytes) else content.encode()
            path = home / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(raw.replace(b"TARGET", str(target).encode()))
        if self.then is not None:
            self.then(home)
        return home


def own(text: str) -> str:
    """The An-26 with something put in front of its end."""
    return GOOD.replace("</fdm_config>", f"{text}</fdm_config>")


def control(text: str) -> str:
    """The An-26 with one more component of a control system."""
    return own(f'<system name="hostile"><channel name="hostile">{text}</channel></system>')


def without(section: str) -> str:
    """The An-26 without a section."""
    return re.sub(f"<{section}.*</{section}>", "", GOOD, flags=re.DOTALL)


def sets(name: str) -> str:
    """The An-26 with a component that writes a property."""
    return control(
        f'<fcs_function name="q"><function><value>1</value></function><output>{name}</output></fcs_function>'
    )


def table(rows: str) -> str:
    """The An-26 with a component that looks values up."""
    return control(
        '<fcs_function name="q"><function><table><independentVar>velocities/vt-fps</independentVar>'
        f"<tableData>{rows}</tableData></table></function></fcs_function>"
    )


def grown(home: Path) -> None:
    """Make the model a sparse file of 1 GB."""
    os.truncate(home / f"{home.name}.xml", 1 << 30)


def linked(home: Path) -> None:
    """Put the model elsewhere and a link in its place."""
    file = home / f"{home.name}.xml"
    file.symlink_to(file.rename(home.parent / f"{home.name}-elsewhere.xml"))


def linked_folder(home: Path) -> None:
    """Put the folder elsewhere and a link in its place."""
    home.symlink_to(home.rename(home.with_name(f"{home.name}-elsewhere")))


def linked_below(home: Path) -> None:
    """Make a folder inside the model a link to its parent's."""
    (home / "below").symlink_to("/etc")


def piped(home: Path) -> None:
    """Put a pipe, on which a reader waits for ever, in the place of a file."""
    os.mkfifo(home / "pipe.xml")


def emptied(home: Path) -> None:
    """Put a folder in the place of the model."""
    (home / f"{home.name}.xml").unlink()
    (home / f"{home.name}.xml").mkdir()


FLAPS = "flaps_deg = 0\nplacard_speed_mps = 9\nstall_speed_mps = 9"
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "ha"}">' for i in range(10))
STEERS = "steers the simulator"
ABORTS = r"aborts the simulation \(SIGABRT: (std::|vector|cannot).*\)"

MODELS = {
    # what writes, listens and sends
    "writes_a_file": HostileModel(
        FLIES, own('<output name="TARGET/out.csv" type="CSV" rate="10"><rates>ON</rates></output>')
    ),
    "overwrites_a_file": HostileModel(FLIES, own('<output name="TARGET/precious.txt" type="TABULAR" rate="1"/>')),
    "writes_above": HostileModel(FLIES, own('<output name="../../../out.csv" type="CSV" rate="10"/>')),
    "sends": HostileModel(
        FLIES,
        own('<output name="localhost" type="SOCKET" port="4444" protocol="TCP" rate="10"><rates>ON</rates></output>'),
    ),
    "sends_to_flightgear": HostileModel(
        FLIES, own('<output name="localhost" type="FLIGHTGEAR" port="4445" rate="9"/>')
    ),
    "listens": HostileModel(FLIES, own('<input port="4446"/>')),
    "listens_for_packets": HostileModel(FLIES, own('<input type="QTJSBSIM" port="4447" protocol="UDP"/>')),
    "listens_in_a_channel": HostileModel(FLIES, control('<input port="4448"/>')),
    "writes_in_a_system_file": HostileModel(
        FLIES,
        own('<system file="inner"/>'),
        {"inner.xml": '<system name="i"><output name="TARGET/out.csv" type="CSV"><rates>ON</rates></output></system>'},
    ),
    "output_from_a_file": HostileModel(
        FLIES, own('<output file="device"/>'), {"device.xml": '<output name="TARGET/o.csv"/>'}
    ),
    "saves_its_state": HostileModel(STEERS, sets("simulation/write-state-file")),
    "saves_its_state_by_index": HostileModel(STEERS, sets("simulation[0]/write-state-file")),
    "saves_its_state_by_detour": HostileModel(STEERS, sets("fcs/..//./simulation//write-state-file[0]")),
    "saves_its_state_in_a_tail": HostileModel(
        STEERS, own('<system name="x"><property value="1"><x/>simulation/write-state-file</property></system>')
    ),
    "resets": HostileModel(STEERS, sets("simulation/reset")),
    "talks": HostileModel(STEERS, sets("simulation/jsbsim-debug")),
    "brings_another_aircraft": HostileModel("<child>", own('<child name="c172x"/>')),
    "brings_a_planet": HostileModel("<planet>", own("<planet><equatorial_radius>1</equatorial_radius></planet>")),
    "is_a_script": HostileModel("its root is <runscript>", '<runscript name="x"><use aircraft="c172x"/></runscript>'),
    # what reaches out of its folder
    "doctype": HostileModel("DOCTYPE", f'<!DOCTYPE fdm_config [<!ENTITY x SYSTEM "file:///etc/passwd">]>{GOOD}'),
    "entity_bomb": HostileModel("DOCTYPE", f"<!DOCTYPE fdm_config [{LAUGHS}]><fdm_config>&l9;</fdm_config>"),
    "absolute_path": HostileModel("leaves the folder", own('<system file="/etc/passwd"/>')),
    "path_above": HostileModel("leaves the folder", own('<system file="../secret"/>')),
    "path_above_in_the_middle": HostileModel("leaves the folder", own('<system file="a/../../secret"/>')),
    "windows_path": HostileModel("leaves the folder", own(r'<system file="C:\secret"/>')),
    "windows_path_above": HostileModel("leaves the folder", own(r'<system file="..\secret"/>')),
    "home_path": HostileModel("leaves the folder", own('<system file="~/secret"/>')),
    "path_above_of_a_section": HostileModel("leaves the folder", own('<metrics file="../secret"/>')),
    "path_above_of_an_engine": HostileModel(
        "leaves the folder", own('<propulsion><engine file="../../secret"/></propulsion>')
    ),
    "is_a_link": HostileModel("is a link", GOOD, then=linked),
    "folder_is_a_link": HostileModel("is a link", GOOD, then=linked_folder),
    "has_a_linked_folder": HostileModel(
        "is a link|does not exist", own('<system file="below/fstab"/>'), then=linked_below
    ),
    "refers_to_itself": HostileModel("refers to itself", own('<system file="refers_to_itself"/>')),
    "refers_in_a_ring": HostileModel(
        FLIES,
        own('<system file="a"/>'),
        {f"{a}.xml": f'<system name="{a}"><channel name="{a}"/><system file="{b}"/></system>' for a, b in ("ab", "ba")},
    ),
    # what is too much
    "one_gigabyte": HostileModel("larger than 4 MB", GOOD, then=grown),
    "deep": HostileModel("nests more than", own("<a>" * 100_000 + "</a>" * 100_000)),
    "wide": HostileModel("has more than", own("<a/>" * 200_000)),
    "many_files": HostileModel(
        "more than 100 files",
        own("".join(f'<system file="s{i}"/>' for i in range(150))),
        {f"s{i}.xml": f'<system name="s{i}"/>' for i in range(150)},
    ),
    "many_large_files": HostileModel(
        "8 MB together",
        own("".join(f'<system file="s{i}"/>' for i in range(3))),
        {f"s{i}.xml": f'<system name="s{i}">{" " * 3_900_000}</system>' for i in range(3)},
    ),
    "huge_table": HostileModel(".", table("".join(f"{i} {i}\n" for i in range(20_000)))),
    "long_reference": HostileModel("1 to 200 characters", own(f'<system file="{"a" * 5000}"/>')),
    "has_a_pipe": HostileModel("does not exist|no regular file", own('<system file="pipe"/>'), then=piped),
    "is_a_folder": HostileModel("must hold", GOOD, then=emptied),
    "data_of_100_mb": HostileModel(
        "larger than", GOOD, then=lambda home: (home / f"{home.name}.toml").write_bytes(b"#" * 2_000_000) and None
    ),
    # what aborts or confuses JSBSim
    "memory_without_end": HostileModel(ABORTS, control(REVERSE_DELAY)),
    "no_controls": HostileModel("cannot be used|cannot load|aborts", without("flight_control")),
    "no_aerodynamics": HostileModel("cannot be used", without("aerodynamics")),
    "no_gear": HostileModel("cannot load", without("ground_reactions")),
    "no_mass": HostileModel("no complete <mass_balance>", without("mass_balance")),
    "no_engines": HostileModel(".", without("propulsion")),
    "not_a_number": HostileModel("must be a number", GOOD.replace(">20000<", ">nan<")),
    "infinite": HostileModel("must be a number", GOOD.replace(">20000<", ">1e999<")),
    "negative_mass": HostileModel("mass", GOOD.replace(">20000<", ">-20000<")),
    "no_mass_at_all": HostileModel("mass|cannot be trimmed|not finite", GOOD.replace(">20000<", ">0<")),
    "no_wing": HostileModel("cannot be trimmed|with these numbers", re.sub(r"(<wingarea[^>]*>)[^<]*", r"\g<1>0", GOOD)),
    "infinite_wing": HostileModel("numeric", re.sub(r"(<wingarea[^>]*>)[^<]*", r"\g<1>inf", GOOD)),
    "unknown_unit": HostileModel("FURLONG2", GOOD.replace('unit="M2"', 'unit="FURLONG2"')),
    "words_for_numbers": HostileModel(
        "cannot be used|aborts", control('<pure_gain name="p"><input>a</input><gain>x</gain></pure_gain>')
    ),
    "empty_table": HostileModel("tableData", table("")),
    "table_of_words": HostileModel("cannot load", table("1 2\nx y")),
    "unknown_property": HostileModel(
        "cannot|aborts", control('<pure_gain name="p"><input>no/such</input><gain>1</gain></pure_gain>')
    ),
    # what is no text
    "empty": HostileModel("not well-formed", ""),
    "half": HostileModel("not well-formed", GOOD[:2000]),
    "binary": HostileModel("not well-formed|cannot be read", bytes(range(256)) * 100),
    "latin_1": HostileModel(
        "not well-formed|cannot be read", GOOD.replace("</fdm_config>", "<!-- \xe9 --></fdm_config>").encode("latin-1")
    ),
    "unknown_encoding": HostileModel(
        "not well-formed|cannot be read",
        GOOD.replace("utf-8", "klingon", 1)
        if "utf-8" in GOOD
        else '<?xml version="1.0" encoding="klingon"?>' + GOOD[GOOD.find("<fdm_config") :],
    ),
    "utf_16": HostileModel(FLIES, GOOD[GOOD.find("<fdm_config") :].encode("utf-16")),
    "byte_order_mark": HostileModel(FLIES, b"\xef\xbb\xbf" + GOOD.encode()),
    "control_characters": HostileModel("does not exist", own('<system file="&#155;2J&#10;shortfinal: good"/>')),
    # data beside the model
    "data_of_nonsense": HostileModel("not|cannot be read", GOOD, {"data_of_nonsense.toml": "= = ="}),
    "data_deep": HostileModel("cannot be read", GOOD, {"data_deep.toml": "x = " + "[" * 100_000}),
    "data_of_wrong_kinds": HostileModel("finite number", GOOD, {"data_of_wrong_kinds.toml": "mass_max_kg = [1]"}),
    "data_not_a_number": HostileModel("finite number", GOOD, {"data_not_a_number.toml": "mass_max_kg = nan"}),
    "data_of_no_mass": HostileModel(
        "reference_mass",
        GOOD,
        {"data_of_no_mass.toml": "reference_mass_kg = 0\n[[flap_settings]]\n" + FLAPS},
    ),
    "data_of_tables_for_texts": HostileModel("other way round", GOOD, {"data_of_tables_for_texts.toml": "sources = 3"}),
    # names
    "an26": HostileModel(FLIES, GOOD),
    "c172x": HostileModel(FLIES, GOOD),
    "a b": HostileModel(FLIES, GOOD),
    ODD_NAME: HostileModel(FLIES, GOOD),
}
