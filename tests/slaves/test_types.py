"""What crosses a connection besides plain numbers: elements of arrays, other types by transformation, strings and binaries."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typed_fmus

from gyro_cosim import Algorithm, Connection, GaussSeidel, Iterated, Jacobi, System, SystemComponent, WiringError, simulate
from gyro_cosim.master import Options
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.slaves import open_slave
from gyro_cosim.ssp import read
from gyro_cosim.ssp.packing import pack
from gyro_cosim.systems import Conversion

LINE = (Conversion(explicit=True),)


def system(parts: dict[str, Path], *wires: str, conversions: tuple[Conversion, ...] = (), **values: dict[str, Any]) -> System:
    """Components by name, and connections written as "a.y > b.u"."""
    ends = [[tuple(end.strip().split(".", 1)) for end in wire.split(">")] for wire in wires]
    components = tuple(SystemComponent(name, str(file), values.get(name, {})) for name, file in parts.items())
    return System("s", components, tuple(Connection(a, b, conversions) for a, b in ends))  # type: ignore[arg-type]


# ---- arrays


def test_an_array_feeds_variables_that_are_called_as_its_elements_are(tmp_path: Path) -> None:
    """FMI 3.0 to FMI 2.0, whole, and back by element; the FMI 2.0 description lists them in another order."""
    two, three = typed_fmus.types_2(tmp_path), typed_fmus.types_3(tmp_path)
    plan = system({"a": three, "b": two}, "a.y > b.x", a={"x": "1 2 4"})
    run = simulate(plan, algorithm=Jacobi(0), step=0.1, stop=0.2)
    assert [run.trajectory[f"b.s[{i}]"][-1] for i in (1, 2, 3)] == [2.0, 2 * 4.0, 3 * 8.0]
    assert [run.trajectory.unit(f"{name}[1]") for name in ("a.y", "b.s")] == ["m", "m"]
    back = system({"b": two, "a": three}, "b.s[3] > a.x[1]", "b.s[1] > a.x[3]", b={"x[1]": 5, "x[3]": 7})
    end = simulate(back, algorithm=Jacobi(0), step=0.1, stop=0.2).trajectory.end()
    assert [end[f"a.y[{i}]"] for i in (1, 2, 3)] == [2 * 3 * 7, 0, 2 * 5]


@pytest.mark.parametrize(
    ("wire", "words"),
    [
        ("a.grid > b.x", r"arrays must have the same shape, got 3 x 2 and 3$"),
        ("a.y > b.level", r"arrays must have the same shape, got 3 and a scalar$"),
        ("b.level_out > a.x", r"arrays must have the same shape, got a scalar and 3$"),
        ("a.y[4] > b.level", r"unknown output of 'a': 'y\[4\]'; did you mean 'y\[\d\]'\?"),
    ],
)
def test_arrays_of_other_shapes_are_refused(wire: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words):
        simulate(system({"a": typed_fmus.types_3(tmp_path), "b": typed_fmus.types_2(tmp_path)}, wire))


def test_elements_are_selected_by_their_names(tmp_path: Path, cosim_json: Callable[..., Any]) -> None:
    pack(system({"M": typed_fmus.types_3(tmp_path)}, M={"x": "1 2 3"}), tmp_path / "m.ssp")
    told = cosim_json("run", "m.ssp", "--stop", "0.1", "--select", "M.y[2]", "--select", "M.grid[3,1]")
    assert told["end"] == {"M.y[2]": 4.0, "M.grid[3,1]": 31.0}
    assert told["units"]["M.y[2]"] == "m"


# ---- types by transformation


@pytest.mark.parametrize(
    ("wire", "conversion", "given", "wanted"),
    [
        ("a.on_out > b.level", Conversion(explicit=True), {"on": True}, 1.0),
        ("a.on_out > b.level", Conversion(factor=-3.0, offset=0.5), {"on": True}, -2.5),
        ("a.whole_out > b.level", Conversion(factor=0.25), {"whole": 7}, 1.75),
        ("a.on_out > b.level", Conversion(table=((0.0, -1.0), (1.0, 2.0))), {"on": True}, 2.0),
        ("a.on_out > b.whole", Conversion(table=((0.0, 4.0), (1.0, 5.0))), {"on": False}, 4.0),
        ("a.level_out > b.whole", Conversion(explicit=True), {"level": 2.6}, 3.0),
        ("a.level_out > b.whole", Conversion(factor=10.0), {"level": 2.6}, 26.0),
        ("a.level_out > b.on", Conversion(explicit=True), {"level": 0.5}, 1.0),
        ("a.level_out > b.on", Conversion(explicit=True), {"level": 0.49}, 0.0),
        ("a.whole_out > b.on", Conversion(factor=-1.0, offset=1.0), {"whole": 0}, 1.0),
    ],
)
def test_other_types_are_joined_by_an_explicit_transformation(
    wire: str, conversion: Conversion, given: dict[str, Any], wanted: float, tmp_path: Path
) -> None:
    file = typed_fmus.types_2(tmp_path)
    plan = system({"a": file, "b": file}, wire, conversions=(conversion,), a=given)
    run = simulate(plan, step=0.1, stop=0.2)
    np.testing.assert_array_equal(run.trajectory[f"{wire.split('>')[1].strip()}_out"], np.full(3, wanted))
    packed = read(pack(plan, tmp_path / "p.ssp"))
    np.testing.assert_array_equal(simulate(packed, step=0.1, stop=0.2).trajectory.values, run.trajectory.values)


@pytest.mark.parametrize(
    ("wire", "conversions", "words"),
    [
        (
            "a.on_out > b.level",
            (),
            r"types must fit: a\.on_out is a boolean, b\.level a real; a LinearTransformation can join them$",
        ),
        ("a.level_out > b.whole", (), r"a\.level_out is a real, b\.whole an integer; a LinearTransformation can join them$"),
        ("a.level_out > b.on", (Conversion(table=((0.0, 1.0),)),), r"must be of whole numbers, a\.level_out is a real$"),
        ("a.whole_out > b.on", (Conversion(table=((0.0, 2.0),)),), r"a mapping's target must be true or false, got 2"),
        ("a.on_out > b.whole", (Conversion(table=((0.0, 1.0),)), Conversion(factor=2.0)), "must not be mixed"),
        ("a.said > b.level", LINE, r"types must fit: a\.said is a string, the other end is none$"),
        ("a.level_out > b.heard", LINE, r"types must fit: a\.level_out is of type real, b\.heard of type string$"),
        ("a.said > b.heard", LINE, r"a string must be passed on as it is, without a transformation$"),
    ],
)
def test_types_that_nothing_joins_are_refused(wire: str, conversions: tuple[Conversion, ...], words: str, tmp_path: Path) -> None:
    file = typed_fmus.types_2(tmp_path)
    with pytest.raises(WiringError, match=words):
        simulate(system({"a": file, "b": file}, wire, conversions=conversions))


def test_a_number_beyond_the_bounds_of_an_integer_is_refused(tmp_path: Path) -> None:
    file = typed_fmus.types_2(tmp_path)
    plan = system({"a": file, "b": file}, "a.level_out > b.whole", conversions=LINE, a={"level": 100.6})
    with pytest.raises(WiringError, match=r"a transformation must keep whole within -2\.14748e\+09 and 100, it gives 100\.6"):
        simulate(plan, step=0.1, stop=0.2)


# ---- strings and binaries


@pytest.mark.parametrize("algorithm", [Jacobi(1), GaussSeidel(0), Iterated(1)], ids=lambda a: a.name)
@pytest.mark.parametrize("isolate", [False, True])
def test_strings_are_passed_on_at_communication_points(algorithm: Algorithm, isolate: bool, tmp_path: Path) -> None:
    """The number of steps done, written out by a, is as long as the string that b and, behind it, c have heard."""
    file = typed_fmus.types_2(tmp_path)
    plan = system({"c": file, "b": file, "a": file}, "a.news > b.heard", "b.said > c.heard")
    t = simulate(plan, algorithm=algorithm, step=0.1, stop=1.2, isolate=isolate).trajectory
    np.testing.assert_array_equal(t["b.length"], np.char.str_len(t["a.steps"].astype(int).astype(str)))
    np.testing.assert_array_equal(t["c.length"], t["b.length"] + 1)
    assert t["c.length"][-1] == 3


@pytest.mark.parametrize("events", [False, True])
def test_texts_cross_from_one_version_to_the_other_and_binaries_too(events: bool, tmp_path: Path) -> None:
    """With event mode each text that changes is an event; one that stays as it is, is none."""
    two, three = typed_fmus.types_2(tmp_path), typed_fmus.types_3(tmp_path, events=events)
    plan = system({"a": three, "b": two, "c": three}, "a.said > b.heard", "b.news > c.heard", "a.copy > c.blob",
                  a={"heard": "Ä∂", "blob": "00ff0180"})  # fmt: skip
    run = simulate(plan, step=0.1, stop=1.0)
    assert run.trajectory["b.length"][-1] == len("Ä∂?".encode())
    assert run.events == ({"a": 0, "c": 10} if events else {})
    assert run.without_kernel == "strings or binaries are passed on in it"


def test_an_fmu_reads_back_what_it_was_told(tmp_path: Path) -> None:
    slave = open_slave("s", str(typed_fmus.types_3(tmp_path)))
    slave.begin({"heard": "Ä∂"}, 0.0, 1.0)
    assert slave.give_texts({"blob": b"\x00\x01\xff"}, 0.0)
    assert slave.texts(0.0) == ("Ä∂?", b"\xff\x01\x00")
    assert not slave.give_texts({"blob": b"\x00\x01\xff"}, 0.0)
    slave.close()


def test_a_resumed_run_has_the_same_texts(tmp_path: Path) -> None:
    def kill(k: int) -> None:
        if k == 8:
            raise KeyboardInterrupt

    file = typed_fmus.types_2(tmp_path)
    plan = system({"b": file, "a": file}, "a.news > b.heard")
    whole = simulate(plan, step=0.1, stop=1.2)
    simulate(plan, step=0.1, stop=1.2, before_step=kill, options=Options(checkpoint=Checkpoint(tmp_path / "c.npz", 0.5)))
    again = simulate(plan, step=0.1, stop=1.2, options=Options(resume=Resume(tmp_path / "c.npz")))
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)


# ---- structural parameters


@pytest.mark.parametrize("isolate", [False, True])
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_a_structural_parameter_decides_on_the_sizes_of_arrays(n: int, isolate: bool, tmp_path: Path) -> None:
    """Whole arrays of the new size are connected; what is left of start values stays, what the FMU begins with does, too."""
    file = typed_fmus.types_3(tmp_path)
    plan = system({"a": file, "b": file}, "a.y > b.x", a={"n": n, "x": [*range(1, n + 1)]}, b={"n": str(n)})
    run = simulate(plan, algorithm=Jacobi(0), step=0.1, stop=0.2, isolate=isolate)
    assert [name for name in run.trajectory.names if name.startswith("b.y")] == [f"b.y[{i}]" for i in range(1, n + 1)]
    assert [run.trajectory[f"b.y[{i}]"][-1] for i in range(1, n + 1)] == [4.0 * i for i in range(1, n + 1)]
    assert run.trajectory[f"a.grid[{n},2]"][-1] == 10 * n + 2
    assert run.trajectory["a.sum"][-1] == n * (n + 1) / 2


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"n": 6}, r"a\.n: must be at most 5, got 6"),
        ({"n": 2.5}, r"a\.n: must be a whole number, got 2\.5"),
        ({"n": 4, "x": "1 2 3"}, r"a\.x: must have 4 values \(4\), got 3"),
        ({"n": 4, "w[2]": 1}, r"w must be given as a whole, since its size is not that of its start values"),
        ({"m": 4}, r"unknown parameter of 'a': 'm'"),
    ],
)
def test_structural_parameters_that_do_not_fit_are_refused(values: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words):
        simulate(system({"a": typed_fmus.types_3(tmp_path)}, a=values), step=0.1, stop=0.2)


def test_a_structural_parameter_cannot_change_once_the_fmu_is_open(tmp_path: Path) -> None:
    slave = open_slave("s", str(typed_fmus.types_3(tmp_path)), values={"n": 2})
    with pytest.raises(
        ValueError, match=r"structural parameter s\.n must be given before the FMU is opened: it is 2 there, not 3"
    ):
        slave.begin({"n": 3.0}, 0.0, 1.0)
    slave.close()


def test_a_structural_parameter_is_packed_and_shown(tmp_path: Path, cosim_json: Callable[..., Any]) -> None:
    plan = system({"a": typed_fmus.types_3(tmp_path)}, a={"n": 2, "x": "3 4"})
    pack(plan, tmp_path / "n.ssp")
    told = cosim_json("run", "n.ssp", "--stop", "0.1")
    assert (told["end"]["a.y[1]"], told["end"]["a.y[2]"], "a.y[3]" in told["end"]) == (6.0, 8.0, False)
    assert cosim_json("run", "n.ssp", "--stop", "0.1", "--set", "a.n=4", "--set", "a.x=9 8 7 6")["end"]["a.y[4]"] == 12.0
    assert [part["ignored_values"] for part in cosim_json("info", "n.ssp")["components"]] == [[]]
