"""FMUs that carry no binary for this machine are compiled from their sources, where they list them."""

import re
import sys
import zipfile

import numpy as np
import pytest

from gyro_cosim.cli import main
from gyro_cosim.fmus import compiler, export
from gyro_cosim.slaves import open_slave
from gyro_cosim.systems.catalogue import component
from gyro_cosim.trajectory import read_results


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The linear gyro unit as FMUs of FMI 2.0 and 3.0, with binary and sources, by version."""
    folder = tmp_path_factory.mktemp("exported")
    return {version: export(component("gyro_unit:linear"), folder / version, fmi=(version[0],))[0] for version in ("2.0", "3.0")}


def changed(fmu, file, change=lambda name, text: text):
    """A copy without binaries, whose texts `change` has seen; None leaves a member out."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(file, "w") as target:
        for name in source.namelist():
            if name.startswith("binaries/"):
                continue
            data = source.read(name)
            if name.endswith((".xml", ".c", ".h")):
                text = change(name, data.decode())
                if text is None:
                    continue
                data = text.encode()
            target.writestr(name, data)
    return file


def run(file, output):
    return main(["run", str(file), "--stop", "1", "--step", "1e-3", "--output", str(output)])


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu_of_sources_gives_the_bits_of_its_binary(exported, version, tmp_path):
    prefixed = changed(exported[version], tmp_path / "sources.fmu")
    assert run(exported[version], tmp_path / "binary.csv") == 0
    assert run(prefixed, tmp_path / "sources.csv") == 0
    binary, sources = (read_results(tmp_path / f"{name}.csv") for name in ("binary", "sources"))
    assert np.array_equal(binary.values, sources.values)
    assert len(binary.t) == 1001


def lists(names):
    """Another list of sources in FMI 2.0's words alone."""

    def change(name, text):
        if name.endswith("buildDescription.xml"):
            return None
        if name == "modelDescription.xml":
            files = "".join(f'<File name="{n}"/>' for n in names)
            return re.sub(
                r"<SourceFiles>.*?</SourceFiles>", f"<SourceFiles>{files}</SourceFiles>" if names else "", text, flags=re.S
            )
        return text

    return change


def drop(name, text):
    return None if name == "sources/fmu.c" else text


def broken(name, text):
    return text + "\nint unfinished( {\n" if name == "sources/fmu.c" else text


def build(old, new):
    """Another buildDescription.xml."""

    def change(name, text):
        if not name.endswith("buildDescription.xml"):
            return text
        assert old in text
        return text.replace(old, new)

    return change


@pytest.mark.parametrize(
    ("version", "change", "words"),
    [
        ("2.0", lists([]), "must list its sources in SourceFiles to be compiled"),
        ("2.0", lists(["../fmu.c"]), "must list sources inside the FMU, lists '../fmu.c'"),
        ("2.0", lists(["-shared"]), "must list sources inside the FMU, lists '-shared'"),
        ("2.0", drop, "must hold the source that it lists, sources/'fmu.c'"),
        ("2.0", broken, "its sources do not compile"),
        ("3.0", build('language="C99"', 'language="C++17"'), "its buildDescription.xml must list sources in C, lists C++17"),
        (
            "3.0",
            build("</BuildConfiguration>", '<Library name="lapack"/></BuildConfiguration>'),
            "must need no library from elsewhere, needs lapack",
        ),
        ("3.0", build("<SourceFile ", "<SourceFiel "), "its buildDescription.xml must keep its schema: line "),
        ("3.0", build('modelIdentifier="', 'modelIdentifier="other_'), "must have a BuildConfiguration of "),
    ],
)
def test_sources_that_cannot_be_compiled_are_refused_in_a_line(exported, version, change, words, tmp_path, capsys):
    file = changed(exported[version], tmp_path / "broken.fmu", change)
    assert run(file, tmp_path / "x.csv") == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1
    assert not (tmp_path / "x.csv").exists()


def test_each_set_of_sources_has_definitions_of_its_own(exported, tmp_path):
    """Two more files, of two sets, that contradict one another unless each is given its own value of one name."""
    sets = "".join(
        f'<SourceFileSet language="C99"><SourceFile name="more{k}.c"/><PreprocessorDefinition name="WHICH" value="{k}"/>'
        f'<PreprocessorDefinition name="BROKEN" optional="true"/></SourceFileSet>'
        for k in (1, 2)
    )
    file = changed(exported["3.0"], tmp_path / "sets.fmu", build("</BuildConfiguration>", f"{sets}</BuildConfiguration>"))
    with zipfile.ZipFile(file, "a") as fmu:
        for k in (1, 2):
            fmu.writestr(f"sources/more{k}.c", f"#if WHICH != {k} || defined(BROKEN)\n#error\n#endif\nint more{k};\n")
    assert run(file, tmp_path / "sets.csv") == 0


def test_options_that_are_not_used_are_told(exported, tmp_path, caplog):
    file = changed(exported["3.0"], tmp_path / "options.fmu", build("-ffp-contract=off", "-ffast-math"))
    with caplog.at_level("WARNING"):
        open_slave("s", str(file)).close()
    assert "options that are not used: -ffast-math" in caplog.text


def test_a_compiler_that_never_ends_is_stopped(monkeypatch, tmp_path):
    monkeypatch.setattr(compiler, "PATIENCE", 0.05)
    monkeypatch.setattr(compiler, "_command", lambda *_: [sys.executable, "-c", "import time; time.sleep(60)"])
    with pytest.raises(compiler.CompilerError, match=r"must be done within 0\.05 s, it is not"):
        compiler.foreign_library(tmp_path, {"a.c": ()}, "a", [])
