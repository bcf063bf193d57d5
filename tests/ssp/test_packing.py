"""A system packed into an .ssp: it keeps the schema, runs alike, here and elsewhere; what `info` and `pack` say."""

import importlib.util
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest
import small_fmus
from lxml import etree

from gyro_cosim import Connection, Jacobi, System, SystemComponent, simulate, system
from gyro_cosim.ssp.packing import pack
from gyro_cosim.systems import Conversion, Exchange, catalogue


def schema(name: str) -> etree.XMLSchema:
    """SSP's own schema, which FMPy ships."""
    (place,) = importlib.util.find_spec("fmpy").submodule_search_locations  # type: ignore[union-attr]
    return etree.XMLSchema(file=str(Path(place) / "ssp" / "schema" / f"{name}.xsd"))


def packable(folder: Path) -> System:
    """Every type, units that only an FMU knows, a transformation and a table between them."""
    m, a = str(small_fmus.mixed(folder)), str(small_fmus.arrays(folder))
    return System(
        "all kinds",
        (
            SystemComponent("m", m, {"u": "100 m", "mode": "fast", "on": False, "text": "x < y", "add": 3}),
            SystemComponent("a", a, {"gain": "1 2 3", "blob": b"\x00\x01", "label": ("p", "q")}),
            SystemComponent("n", m),
        ),
        (
            Connection(("m", "y"), ("a", "u[3]"), (Conversion(factor=2.0, offset=1.0),)),
            Connection(("m", "on_out"), ("n", "on"), (Conversion(table=((0.0, 1.0), (1.0, 0.0))),)),
            Connection(("n", "count"), ("a", "tiny")),
        ),
        step=0.01, stop=0.1, exchange=Exchange("n", "_big"),
    )  # fmt: skip


@pytest.mark.parametrize("make", [lambda folder: system("wheel-pair"), lambda folder: oscillators.pair(cubic=3.0), packable])
def test_a_packed_system_keeps_the_schema_and_runs_alike(make: Callable[[Path], System], tmp_path: Path) -> None:
    plan = make(tmp_path)
    file = pack(plan, tmp_path / "packed.ssp")
    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    for name, data in members.items():
        if name.endswith((".ssd", ".ssv")):
            kind = "SystemStructureDescription" if name.endswith(".ssd") else "SystemStructureParameterValues"
            schema(kind).assertValid(etree.fromstring(data))
    again = system(str(file))
    assert (again.name, again.step, again.stop, again.bonds) == (plan.name, plan.step, plan.stop, plan.bonds)
    assert again.exchange == plan.exchange
    runs = [simulate(p, step=0.01, stop=0.1, algorithm=Jacobi(1)).trajectory for p in (plan, again)]
    assert runs[0].names == runs[1].names
    np.testing.assert_allclose(runs[0].values, runs[1].values, rtol=1e-13, atol=1e-15)  # values went through text and units
    assert pack(plan, tmp_path / "again.ssp").read_bytes() == file.read_bytes()


@pytest.mark.filterwarnings("ignore")
def test_another_importer_runs_a_packed_system(tmp_path: Path) -> None:
    """FMPy's: all components side by side, inputs held, everything zero before the first step, as here with Jacobi(0)."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import read_ssv

    plan = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")
    file = pack(plan, tmp_path / "wheel-pair.ssp")
    values = tmp_path / "values.ssv"
    with zipfile.ZipFile(file) as archive:
        values.write_bytes(archive.read("resources/gyro.ssv"))
    parameters = read_ssv(str(values))
    for parameter in parameters.parameters:
        parameter.name = f"gyro.{parameter.name}"  # it takes one set, for the whole system
    h, n = 2.0**-10, 300  # a step that adds up exactly
    rows = simulate_ssp(str(file), stop_time=n * h, step_size=h, parameter_set=parameters)
    mine = simulate(plan, step=h, stop=n * h, algorithm=Jacobi(0)).trajectory
    for name in ("vehicle.yaw_angle", "gyro.gimbal_angle"):
        assert rows[name][-1] == pytest.approx(mine[name][-1], rel=1e-12)
    assert abs(rows["gyro.gimbal_angle"][-1]) > 1e-3


def test_the_command_line_packs_runs_and_describes(
    cosim: Callable[..., Any], cosim_json: Callable[..., Any], tmp_path: Path
) -> None:
    code, out, err = cosim("pack", "wheel-pair", "--set", "gyro.rotor_speed=200rpm", "-o", "mine.ssp")
    assert (code, out) == (0, "wrote mine.ssp\n"), err
    packed = cosim_json("run", "mine.ssp", "--stop", "0.2")
    built_in = cosim_json("run", "wheel-pair", "--set", "gyro.rotor_speed=200rpm", "--stop", "0.2")
    assert packed["end"] == built_in["end"]
    found = cosim_json("info", "mine.ssp")
    assert {(w["from"], w["to"]) for w in found["connections"]} == {
        ("vehicle.yaw_rate", "gyro.yaw_rate"), ("gyro.yaw_moment", "vehicle.yaw_moment"),
    }  # fmt: skip
    assert found["bonds"] == ["vehicle.yaw_rate x gyro.yaw_moment"]
    assert found["loops"] == []
    assert float(found["components"][1]["values"]["rotor_speed"]) == pytest.approx(200 * 2 * np.pi / 60)
    code, out, err = cosim("info", "mine.ssp")
    assert "power bond: vehicle.yaw_rate x gyro.yaw_moment" in out
    assert "gyro.yaw_moment [N.m]" in out
    assert cosim("pack", "wheel-pair", "-o", "mine.zip")[0] == 2


def test_info_describes_an_fmu(cosim: Callable[..., Any], cosim_json: Callable[..., Any], tmp_path: Path) -> None:
    (file,) = catalogue.export("gyro_unit:linear", tmp_path, fmi=("3",))
    found = cosim_json("info", str(file))
    assert found["fmi"] == "3.0"
    assert found["interfaces"]["CoSimulation"]["providesIntermediateUpdate"] == "true"
    assert {"name": "yaw_rate", "causality": "input", "unit": "rad/s"}.items() <= next(
        v for v in found["variables"] if v["name"] == "yaw_rate"
    ).items()
    assert {"output": "pitch_moment", "inputs": ["pitch_rate"]} in found["direct_feedthrough"]
    code, out, _ = cosim("info", str(small_fmus.arrays(tmp_path)))
    assert code == 0
    assert "Float64[3]" in out
    code, _, err = cosim("info", str(tmp_path / "none.fmu"))
    assert code == 2
    assert "none.fmu' must exist" in err
