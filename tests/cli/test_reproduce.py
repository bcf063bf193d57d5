"""Results say where they come from, and are made again to the last bit."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import small_fmus

from gyro_cosim.trajectory import read_with_origin


def test_a_result_is_made_again_or_the_first_difference_told(cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    """From a folder beside, with an input file and an FMU that are named in the command; then with one of them changed."""
    small_fmus.mixed(Path.cwd(), unit_in="m", unit_out="m")
    Path("u.csv").write_text("time,u\n0,0\n1,2\n")
    Path("out").mkdir()
    command = ("run", "mixed.fmu", "--stop", "1", "--step", "0.1", "--input", "u.csv")
    run = cosim_json(*command, "--output", "out/r.csv", "--plot", "r.png")
    results, origin = read_with_origin("out/r.csv")
    assert origin is not None
    assert origin.command == (*command, "--output", "out/r.csv", "--plot", "r.png", "--json")
    assert (origin.folder, set(origin.hashes)) == ("..", {"mixed.fmu", "u.csv"})
    assert results.unit("mixed.y") == "m"
    assert run["origin"]["hashes"] == origin.hashes

    code, out, err = cosim("reproduce", "out/r.csv")
    assert (code, err) == (0, "")
    assert out == f"cosim {' '.join(command)}\nthe same, bit by bit: 11 points of 4 signals\n"

    Path("u.csv").write_text("time,u\n0,0\n0.5,1\n1,2.5\n")
    told = json.loads(Path("out/r.csv.origin.json").read_text())
    told["versions"]["numpy"] = "0.1"
    Path("out/r.csv.origin.json").write_text(json.dumps(told))
    code, out, err = cosim("reproduce", "out/r.csv", "--json")
    found = json.loads(out)
    assert code == 1
    assert found["changed"][0].startswith("numpy was 0.1, is ")
    assert found["changed"][1:] == ["u.csv has changed"]
    assert (found["difference"]["signal"], round(found["difference"]["time"], 9)) == ("mixed.y", 0.6)
    assert "cosim: note: u.csv has changed" in err


def test_what_cannot_be_made_again_is_refused_in_one_line(cosim: Callable[..., Any]) -> None:
    Path("r.csv").write_text("time,a\n0.0,1.0\n")
    beside = Path("r.csv.origin.json")
    code, _, err = cosim("reproduce", "r.csv")
    assert (code, err.count("\n")) == (2, 1)
    assert "'r.csv' must say where it comes from" in err
    for text, says in (
        ('{"gyro_cosim_origin": 2}', "its format must be 1, is 2"),
        ("[" * 100_000, "must tell where results come from"),
        ('{"gyro_cosim_origin": 1, "command": [1], "folder": ".", "versions": {}, "hashes": {}, "units": {}}', "must hold texts"),
        (
            '{"gyro_cosim_origin": 1, "command": ["sweep"], "folder": ".", "versions": {}, "hashes": {}, "units": {}}',
            "it comes from 'sweep'",
        ),
        ('{"gyro_cosim_origin": 1, "command": ["run"], "folder": "no", "versions": {}, "hashes": {}, "units": {}}', "must exist"),
    ):
        beside.write_text(text)
        code, _, err = cosim("reproduce", "r.csv")
        assert (code, err.count("\n")) == (2, 1), err
        assert says in err
