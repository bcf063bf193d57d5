"""What people and programs read: names as they are, valid JSON."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import oscillators
import pytest
from rich.table import Table

from gyro_cosim.cli.common import console, nulled, progress, say

MARKED = "[red]x[/red] [0, 1] :smile: [/]"


def test_json_holds_null_for_every_number_that_is_none_of_json(capsys: pytest.CaptureFixture[str]) -> None:
    document = {"a": math.nan, "b": [1.0, -math.inf, (math.inf, "NaN, Infinity and -Infinity")], "NaN": {"c": None, "d": True}}
    say(True, lambda: document)
    said = capsys.readouterr().out
    expected = {"a": None, "b": [1.0, None, [None, "NaN, Infinity and -Infinity"]], "NaN": {"c": None, "d": True}}
    assert json.loads(said, parse_constant=pytest.fail) == nulled(document) == expected


def test_nothing_in_a_name_or_a_message_is_markup(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("name", MARKED, box=None)
    table.add_row(MARKED, "1")
    say(False, dict, MARKED, table)
    assert capsys.readouterr().out.count(MARKED) == 3
    console().print(MARKED)
    assert MARKED in capsys.readouterr().err


def test_a_component_with_a_marked_name_is_run_and_shown_as_it_is(cosim: Callable[..., Any], tmp_path: Path) -> None:
    from gyro_cosim import System, SystemComponent
    from gyro_cosim.ssp.packing import pack

    pack(System("[b]s[/b]", (SystemComponent(MARKED, f"{oscillators.HERE}:crossed"),), ()), tmp_path / "s.ssp")
    for command in (("run", "s.ssp", "--stop", "0.1"), ("info", "s.ssp")):
        code, out, err = cosim(*command)
        assert code == 0, err
        assert "[b]s[/b]" in out
        assert MARKED in out
    code, _, err = cosim("run", "s.ssp", "--set", f"{MARKED}.gain=[0, 1]")
    assert code == 2
    assert "[0, 1]" in err


def test_a_bar_takes_any_name_and_tells_whom_it_is_given_to(monkeypatch: pytest.MonkeyPatch) -> None:
    from rich.progress import Progress as Bar

    seen: list[Any] = []
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr(Bar, "update", lambda self, task, **how: seen.append((self.tasks[0].description, how)))
    with progress("running {x} [b]y[/b]") as show:
        show(1, 4)
    assert seen == [("running {x} [b]y[/b]", {"completed": 1, "total": 4})]


def test_results_go_into_several_files(cosim: Callable[..., Any], tmp_path: Path) -> None:
    from gyro_cosim import read_csv

    code, out, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--output", "a.csv", "--output", "b.mat")
    assert code == 0, err
    assert "wrote a.csv" in out
    assert "wrote b.mat" in out
    assert len(read_csv(tmp_path / "a.csv")) == 101
    assert (tmp_path / "b.mat").is_file()
    code, _, err = cosim("run", "wheel-pair", "--output", "a.csv", "--output", "a.csv")
    assert (code, err) == (2, "cosim: --output must name different files, got 'a.csv' twice\n")


def test_too_many_results_for_memory_go_into_one_csv_only(tmp_path: Path) -> None:
    from gyro_cosim.cli.results import Files

    files = Files((tmp_path / "a.mat", tmp_path / "b.csv"), None)
    assert files.recording((), 1, 1000, always=False, never=False).stream is None
    assert files.recording((), 1, 3_000_000, always=False, never=False).stream == tmp_path / "b.csv"
    with pytest.raises(ValueError, match=r"go into one \.csv file only, got '.*a\.mat' besides"):
        files.recording((), 1, 30_000_000, always=False, never=False)
    assert files.recording((), 10, 30_000_000, always=False, never=False).stream == tmp_path / "b.csv"
