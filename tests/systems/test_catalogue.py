"""What is installed and how it is found; an FMU in the cache is that of the component as it is now."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gyro_cosim.systems import catalogue, machine_code

MINE = """
import casadi as ca
from gyro_cosim.component import build, output, parameter, state
{imports}
def component():
    return build(
        name="mine", variant="one", description="d", equations="x' = -k x", internal_step={step},
        variables=[state("x", "m", "place"), output("y", "m", "out"), parameter("k", {k}, "1/s", "rate", source="{source}")],
        model=lambda s: ({{"x": -s["k"] * s["x"]}}, {{"y": {gain} * s["x"]}}),
    )
"""
PLAIN = {"imports": "", "step": "1e-3", "k": "2.0", "source": "rig", "gain": "3.0"}


@pytest.fixture
def mine(tmp_path: Path) -> Callable[..., Path]:
    """The FMU of mine.py written with some values."""

    def built(**changed: str) -> Path:
        (tmp_path / "mine.py").write_text(MINE.format(**(PLAIN | changed)))
        return catalogue.fmu(f"{tmp_path}/mine.py")

    return built


@pytest.mark.parametrize(("what", "value"), [("k", "2.5"), ("gain", "4.0"), ("step", "2e-3"), ("source", "another rig")])
def test_an_fmu_is_built_anew_when_what_it_holds_changes(what: str, value: str, mine: Callable[..., Path]) -> None:
    first = mine()
    assert mine(**{what: value}) != first
    assert mine() == first
    assert mine(imports="\nUNUSED = 1\n") == first  # the same component, whatever stands around it


def test_a_module_that_the_file_imports_counts_too(
    mine: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a file that builds on gyro_unit/parameters.py does: the change is in what is imported, not in the file."""
    monkeypatch.syspath_prepend(str(tmp_path))
    found = []
    for k in ("2.0", "7.0", "2.0"):
        (tmp_path / "rates_of_mine.py").write_text(f"K = {k}\n")
        sys.modules.pop("rates_of_mine", None)
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        found.append(mine(imports="from rates_of_mine import K\n", k="K"))
    assert found[0] == found[2] != found[1]


def test_the_exporters_sources_count_whoevers_component_it_is(
    mine: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from importlib.util import find_spec

    keys, real = [], find_spec
    for text in ("a", "b"):
        folder = tmp_path / "exporter"
        folder.mkdir(exist_ok=True)
        (folder / "code.c").write_text(text)
        place = type("Place", (), {"submodule_search_locations": [str(folder)]})
        monkeypatch.setattr(catalogue.util, "find_spec", lambda name, p=place: p if name == "gyro_cosim.fmus" else real(name))
        file = f"{tmp_path}/mine.py:component"
        (tmp_path / "mine.py").write_text(MINE.format(**PLAIN))
        keys.append([catalogue.fingerprint(s, m) for s, m in ((file, catalogue.component(file)), ("gyro_unit:linear", None))])
        monkeypatch.setattr(catalogue.util, "find_spec", real)
    assert keys[0][0] != keys[1][0]
    assert keys[0][1] != keys[1][1]


def test_the_key_is_the_same_in_every_process(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MINE.format(**PLAIN))
    script = (
        "from gyro_cosim.systems import catalogue\n"
        "for s in ('mine.py:component', 'vehicle:lrt'): print(catalogue.fingerprint(s, catalogue.component(s)))"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", script], cwd=tmp_path, env={"PYTHONHASHSEED": seed}, check=True, capture_output=True, text=True
        ).stdout
        for seed in ("1", "2")
    }
    assert len(said) == 1
    assert len(said.pop().split()) == 2


# ---- names of before 0.2.0 --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "successor"),
    [
        ("from component import build", "No module named 'component': it is called 'gyro_cosim.component' since 0.2.0"),
        ("from gyro_unit.mount import BONDS", "No module named 'gyro_unit.mount': it is called 'gyro_cosim.gyro_unit.mount'"),
        ("from cosim import simulate", "No module named 'cosim': it is called 'gyro_cosim' since 0.2.0"),
        ("import vehicle", "No module named 'vehicle': it is called 'gyro_cosim.vehicle' since 0.2.0"),
    ],
)
def test_a_component_file_with_old_imports_is_told_the_new_ones(line: str, successor: str, tmp_path: Path) -> None:
    (tmp_path / "old.py").write_text(f"{line}\n")
    run = [str(Path(sys.executable).parent / "cosim"), "run", "wheel-pair", "--in-process", "--gyro", "old.py"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert f"component file 'old.py' cannot be loaded: ModuleNotFoundError: {successor}" in done.stderr


def install(site: Path, entries: str, **modules: str) -> None:
    """A distribution with these modules and entry points."""
    (site / "rig-1.0.dist-info").mkdir(parents=True)
    (site / "rig-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: rig\nVersion: 1.0\n")
    (site / "rig-1.0.dist-info" / "entry_points.txt").write_text(entries)
    for name, text in modules.items():
        (site / f"{name}.py").write_text(text)


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        (
            "[gyro_cosim.components]\nrig = rig_units:VARIANTS\n",
            "component rig:old (vehicle.lrt:lrt) cannot be loaded: No module named 'vehicle.lrt': it is called "
            "'gyro_cosim.vehicle.lrt' since 0.2.0",
        ),
        (
            "[gyro_cosim.components]\nrig = gyro_unit:VARIANTS\n",
            "components 'rig' (gyro_unit:VARIANTS) cannot be loaded: No module named 'gyro_unit': it is called "
            "'gyro_cosim.gyro_unit' since 0.2.0",
        ),
    ],
)
def test_an_entry_point_with_an_old_name_is_told_the_new_one(entries: str, words: str, tmp_path: Path) -> None:
    site = tmp_path / "site"
    install(site, entries, rig_units="VARIANTS = {'old': 'vehicle.lrt:lrt'}\n")
    run = [str(Path(sys.executable).parent / "cosim"), "run", "wheel-pair", "--in-process", "--gyro", "rig:old"]
    done = subprocess.run(run, cwd=tmp_path, env={"PYTHONPATH": str(site)}, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert words in done.stderr


def test_a_component_of_another_distribution_is_built_anew_when_it_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever it is made from: here a module at the top, which stands in no package."""
    site = tmp_path / "site"
    install(site, "[gyro_cosim.components]\nrig = rig_unit:VARIANTS\n")
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    catalogue.components.cache_clear()
    built = []
    try:
        for gain in ("3.0", "5.0", "3.0"):
            text = MINE.format(**(PLAIN | {"gain": gain}))
            (site / "rig_unit.py").write_text(f"VARIANTS = {{'one': 'rig_unit:component'}}\n{text}")
            sys.modules.pop("rig_unit", None)
            built.append(catalogue.fmu("rig:one"))
    finally:
        catalogue.components.cache_clear()
        sys.modules.pop("rig_unit", None)
    assert built[0] == built[2] != built[1]


def test_a_library_that_was_cut_short_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GYRO_COSIM_CACHE", str(tmp_path))
    component = catalogue.component("gyro_unit:linear")
    file = machine_code.of_component(component)
    whole = file.read_bytes()
    file.write_bytes(whole[:100])
    assert machine_code.loaded(lambda: machine_code.of_component(component)).prepare
    assert file.read_bytes() == whole


def test_a_torn_fmu_in_the_cache_is_built_anew(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """And what a killed builder has left long ago goes."""
    monkeypatch.setenv("GYRO_COSIM_CACHE", str(tmp_path))
    file = catalogue.fmu("gyro_unit:linear")
    whole = file.read_bytes()
    left = file.parents[1] / f"{catalogue.SCRATCH}left"
    left.mkdir()
    os.utime(left, (0, 0))
    for torn in (whole[: len(whole) // 2], whole[:1000] + b"\0" * 50 + whole[1050:], b""):
        file.write_bytes(torn)
        assert catalogue.fmu("gyro_unit:linear").read_bytes() == whole
    assert not left.exists()
    assert catalogue.fmu("gyro_unit:linear").stat().st_mtime == file.stat().st_mtime
