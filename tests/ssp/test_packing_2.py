"""A system packed as SSP 2.0, and what a package says of where it comes from."""

import hashlib
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus
from lxml import etree

from gyro_cosim import Connection, Jacobi, System, SystemComponent, simulate, system
from gyro_cosim.ssp.packing import pack
from gyro_cosim.ssp.rules import NAMESPACES, check
from gyro_cosim.ssp.traceability import MEMBER, RESULTS
from gyro_cosim.systems import archive


def arrays(folder: Path) -> System:
    """Two FMUs with arrays, joined whole, and texts and numbers of FMI 3.0 as values."""
    a = str(small_fmus.arrays(folder))
    return System(
        "arrays",
        (
            SystemComponent("a", a, {"gain": "1 2 3", "u": "1 2 3", "label": ("p", "q"), "blob": b"\x00\x01", "tiny": -3}),
            SystemComponent("b", a, {"gain": "4 5 6"}),
        ),
        (Connection(("a", "y"), ("b", "u")),),
        step=0.01, stop=0.05,
    )  # fmt: skip


def document(file: Path, member: str = "SystemStructure.ssd") -> etree._Element:
    return archive.xml(archive.read(f"{file}#{member}"), member)


def test_arrays_stay_whole_in_ssp_2_and_types_are_the_fmus_own(tmp_path: Path) -> None:
    plan = arrays(tmp_path)
    file = pack(plan, tmp_path / "two.ssp", version="2.0")
    root = document(file)
    check(root)
    assert root.get("version") == "2.0"
    y = root.find(".//ssd:Component[@name='a']/ssd:Connectors/ssd:Connector[@name='y']", NAMESPACES)
    assert [(etree.QName(e).localname, e.get("size")) for e in y] == [("Float64", None), ("Dimension", "3")]
    (wire,) = root.iterfind(".//ssd:Connection", NAMESPACES)
    assert (wire.get("startConnector"), wire.get("endConnector")) == ("y", "u")
    values = {e.get("name"): e[0] for e in document(file, "resources/a.ssv").iterfind(".//ssv:Parameter", NAMESPACES)}
    assert values["gain"].get("value") == "1.0 2.0 3.0"
    assert [e.get("value") for e in values["label"]] == ["p", "q"]
    assert (etree.QName(values["tiny"]).localname, values["tiny"].get("value")) == ("Int8", "-3")
    again = system(str(file))
    runs = [simulate(p, step=0.01, stop=0.05, algorithm=Jacobi(0)).trajectory for p in (plan, again)]
    assert runs[0].names == runs[1].names
    np.testing.assert_array_equal(runs[0].values, runs[1].values)
    assert runs[0].end()["b.y[3]"] == 6 * 3 * 3


def test_an_array_of_which_elements_are_connected_is_taken_apart_in_both_versions(tmp_path: Path) -> None:
    whole = arrays(tmp_path)
    single = tuple(Connection(("a", f"y[{i}]"), ("b", f"u[{4 - i}]")) for i in (1, 2, 3))
    plan = System(whole.name, whole.components, single, step=0.01, stop=0.05)
    for version, given in (("1.0", whole), ("1.0", plan), ("2.0", plan)):
        file = pack(given, tmp_path / "p.ssp", version=version)
        names = {e.get("startConnector") for e in document(file).iterfind(".//ssd:Connection", NAMESPACES)}
        assert names == {"y[1]", "y[2]", "y[3]"}
        ends = [simulate(p, step=0.01, stop=0.05, algorithm=Jacobi(0)).trajectory.end() for p in (given, system(str(file)))]
        assert ends[0] == ends[1]
    with pytest.raises(ValueError, match=r"unknown version of SSP '2'; did you mean '2\.0'|unknown version of SSP '2'; known"):
        pack(plan, tmp_path / "p.ssp", version="2")


def entries(file: Path, kind: str) -> dict[str, str]:
    """The classification `kind` of the package's metadata."""
    root = document(file, MEMBER)
    assert root.tag == "{http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData}SimulationResourceMetaData"
    space = {"stc": "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"}
    found = root.findall(f"stc:Classification[@type='io.github.gyro-cosim.{kind}']/stc:ClassificationEntry", space)
    return {e.get("keyword", ""): e.text or "" for e in found}


def test_a_package_says_where_it_comes_from_and_how_right_its_run_was(
    cosim: Callable[..., Any], cosim_json: Callable[..., Any], tmp_path: Path
) -> None:
    """Hashes of every member, versions, and of a run its settings, seed and certificate, beside the whole document."""
    run = cosim_json("run", "wheel-pair", "--step", "2ms", "--stop", "0.1", "--certify", "--in-process")
    (tmp_path / "run.json").write_text(json.dumps(run))
    code, _, err = cosim("pack", "wheel-pair", "--ssp", "2.0", "--run", "run.json", "-o", "w.ssp")
    assert code == 0, err
    file = tmp_path / "w.ssp"
    with zipfile.ZipFile(file) as package:
        members = {name: package.read(name) for name in package.namelist()}
    hashes = entries(file, "sha3-256")
    assert hashes == {name: hashlib.sha3_256(data).hexdigest() for name, data in members.items() if name != MEMBER}
    assert "resources/vehicle.wheel_pair.fmu" in hashes
    assert {"gyro-cosim", "python"} <= set(entries(file, "versions"))
    settings = entries(file, "run")
    assert (settings["algorithm"], settings["step"], settings["results"]) == ("jacobi", "0.002", f"../../{RESULTS}")
    certificate = entries(file, "certificate")
    assert float(certificate["observed_order"]) == run["certificate"]["observed_order"]
    assert float(certificate["stability.spectral_radius"]) == run["certificate"]["stability"]["spectral_radius"]
    assert json.loads(members[RESULTS]) == run
    assert cosim_json("info", "w.ssp")["system"] == "wheel-pair"
    for words, told in (
        (("lrt-straight",), "the run must be of the system that is packed, whose system is lrt-straight, got wheel-pair"),
        (("wheel-pair", "--gyro", "off"), "the run must be of the system that is packed, whose components is"),
        (("wheel-pair", "--as-fmu"), "--run has no effect with --as-fmu, got 'run.json'"),
    ):
        code, _, err = cosim("pack", *words, "--run", "run.json", "-o", "x.ssp")
        assert (code, told in err) == (2, True), err
    code, _, err = cosim("pack", "wheel-pair", "--ssp", "3", "-o", "x.ssp")
    assert (code, "unknown version of SSP '3'; known: 1.0, 2.0" in err) == (2, True)
