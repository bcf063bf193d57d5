"""The files: the same bytes every time, complete or not there at all, refused in one line, rebuildable by others."""

import hashlib
import os
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmu_models import COMPONENTS, gain, in_process, plain, random_steps
from fmu_opening import opened

from gyro_cosim import fmus
from gyro_cosim.fmus.compiler import PLATFORMS, CompilerError, host, universal


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


SLOW = pytest.mark.slow


@pytest.mark.parametrize("name", ["gyro_unit:nonlinear", *(pytest.param(n, marks=SLOW) for n in ("radau", "sampled"))])
def test_exporting_twice_gives_identical_files(built: Callable, name: str, tmp_path: Path) -> None:
    """The component is made anew, in another folder."""
    first = [built(name, version)[1] for version in "23"]
    again = fmus.export(COMPONENTS[name](), tmp_path / "elsewhere", fmi=("2", "3"))
    assert [digest(p) for p in again] == [digest(p) for p in first]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fmi": ("1",)}, "FMI version must be one of 2, 3, got '1'"), ({"fmi": ()}, "fmi must be a sequence"),
        ({"fmi": "2"}, "fmi must be a sequence"), ({"platforms": ("amiga",)}, "platform must be .* got 'amiga'"),
        ({"platforms": ()}, "platforms must name at least one"), ({"platforms": "host"}, "platforms must be a sequence"),
    ],
)  # fmt: skip
def test_wrong_use_is_refused_in_one_line(options: dict, message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        fmus.export(gain(), tmp_path / "out", **options)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_names_that_no_fmu_can_have_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must make a C identifier, got 'pendulum_two words'"):
        fmus.export(replace(plain(), variant="two words"), tmp_path)
    with pytest.raises(ValueError, match="the FMU has a variable 'time' of its own"):
        fmus.export(plain(variables=[replace(v, name="time") if v.name == "d" else v for v in plain().variables],
                          model=lambda s: ({"phi": s["omega"], "omega": s["u"]}, {"y": s["u"]})), tmp_path)  # fmt: skip
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(ValueError, match="directory must be a folder"):
        fmus.export(gain(), file)


def test_a_failing_compiler_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line that names compiler and platform; the folder stays as it was."""
    compiler = tmp_path / "badcc"
    compiler.write_text("#!/bin/sh\necho 'badcc: error: out of ideas' >&2\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(CompilerError, match=r"failed \(badcc\): badcc: error: out of ideas") as caught:
        fmus.export(gain(), tmp_path / "out")
    assert isinstance(caught.value, RuntimeError)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_without_a_compiler_of_its_own_the_machine_uses_zig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the result is the same to the last bit."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    (path,) = fmus.export(plain(), tmp_path)
    steps = random_steps(plain(), 0.01, 20)
    with opened(path, tmp_path / "fmu") as it:
        it.initialize()
        got = [it.step(*step) for step in steps]
    assert np.array_equal(got, in_process(plain(), steps))


def test_an_interrupted_write_leaves_the_old_file(built: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (path,) = fmus.export(gain(), tmp_path)
    before = path.read_bytes()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fmus.export(gain(), tmp_path, sources=False)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before


@pytest.mark.parametrize("version", ["2", pytest.param("3", marks=SLOW)])
def test_others_can_rebuild_from_the_sources_inside(built: Callable, version: str, tmp_path: Path) -> None:
    """What buildDescription.xml says, done with a plain C compiler call, gives the same results."""
    c, path, _ = built("plain", version)
    folder = tmp_path / "fmu"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    description = ET.parse(folder / "sources/buildDescription.xml")
    files = [e.get("name") for e in description.iter("SourceFile")]
    (library,) = folder.glob("binaries/*/*")
    library.unlink()
    command = [sys.executable, "-m", "ziglang", "cc", "-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
    quiet = ["-Wno-unused-parameter", "-Wno-unused-function", "-Wno-unused-variable", "-Wno-missing-field-initializers"]
    subprocess.run([*command, *quiet, "-shared", "-fPIC", "-o", library, *files, "-lm"], cwd=folder / "sources", check=True)
    steps = random_steps(c, 0.01, 5)
    steps = [(t, h, U * [1, 0, 0]) for t, h, U in steps]
    with opened(path, folder) as it:
        it.initialize()
        assert np.array_equal([it.step(*step) for step in steps], in_process(c, steps))


def test_sources_can_be_left_out(tmp_path: Path) -> None:
    (path,) = fmus.export(gain(), tmp_path, sources=False)
    with zipfile.ZipFile(path) as archive:
        assert not [n for n in archive.namelist() if n.startswith("sources/")]
        assert b"SourceFiles" not in archive.read("modelDescription.xml")


def test_the_page_inside_is_made_from_the_component(built: Callable) -> None:
    """Equations, every variable with unit and source, assumed ranges; FMI 3.0 terminals name the bonds' variables."""
    c, path, _ = built("vehicle:wheel_pair", "3")
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
        terminals = ET.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        names = archive.namelist()
    for line in c.equations.splitlines():
        assert line.replace("'", "&#x27;") in page
    for v in c.variables:
        assert f"<td>{v.name}</td>" in page
    assert "assumed, 0.003 to 0.007" in page
    members = [e.get("variableName") for e in terminals.iter("TerminalMemberVariable")]
    assert members == [name for bond in c.bonds for name in (bond.motion, bond.effort)]
    assert {"terminalsAndIcons/icon.png", "documentation/licenses/license.txt", "documentation/diagram.png"} <= set(names)
    assert not [n for n in zipfile.ZipFile(built("vehicle:wheel_pair")[1]).namelist() if n.startswith("terminals")]


def test_a_universal_library_holds_both() -> None:
    """The fat header points at the two libraries, aligned."""
    fat = universal(b"x" * 20000, b"a" * 300)
    magic, count = struct.unpack_from(">II", fat)
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, (cpu, data) in enumerate(((0x01000007, b"x" * 20000), (0x0100000C, b"a" * 300))):
        kind, _, offset, size, align = struct.unpack_from(">IIIII", fat, 8 + 20 * i)
        assert kind == cpu
        assert offset % (1 << align) == 0
        assert fat[offset : offset + size] == data


@pytest.mark.slow
def test_five_platforms_from_this_machine(tmp_path: Path) -> None:
    """Every library is there under the name its folder asks for, and of the right kind; twice the same bytes."""
    from gyro_cosim.check import check_fmu

    paths = fmus.export(plain(), tmp_path / "a", fmi=("2", "3"), platforms=("all",))
    again = fmus.export(plain(), tmp_path / "b", fmi=("2", "3"), platforms=("all",))
    assert [digest(p) for p in paths] == [digest(p) for p in again]
    for path in paths:
        assert [f for f in check_fmu(path) if f.severity != "note"] == []
    folders = {n.split("/")[1] for n in zipfile.ZipFile(paths[1]).namelist() if n.startswith("binaries/")}
    assert folders == set(PLATFORMS)
    assert host().name in folders


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_manifest_of_reference_files_names_what_is_inside(built: Callable, version: str) -> None:
    """By FMI-LS-REF: each place is relative to the manifest; the attributes of the root are those that the standard fixes."""
    _, path, _ = built("gain", version)
    with zipfile.ZipFile(path) as archive:
        root = ET.fromstring(archive.read("extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"))
        names = archive.namelist()
    space = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
    assert root.tag == "fmiReferences"
    assert root.get(f"{space}name") == "org.fmi-standard.fmi-ls-ref"
    assert root.get(f"{space}version") == "1.0.0-alpha.1"
    assert {e.get("role") for e in root} == {"testcase", "result"}
    for element in root:
        place = (Path("/extra/org.fmi-standard.fmi-ls-ref") / element.get("source", "")).as_posix()
        assert Path(os.path.normpath(place)).relative_to("/").as_posix() in names
