"""The README is run as written: its commands, its Python, its tables."""

import contextlib
import io
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gyro_cosim.systems import catalogue

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, flags=re.DOTALL)
COMMANDS = [
    line.partition("#")[0] for kind, text in BLOCKS if kind == "sh" for line in text.splitlines() if line.startswith("cosim")
]
LONG = re.compile("cosim paper|--vehicle wheelset")  # tests/cli draws all of the paper; another vehicle is compiled first
VARIANT = next(text for kind, text in BLOCKS if kind == "python" and text.startswith("# my_gyro.py"))


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(c, marks=pytest.mark.slow) if "cosim paper" in c or "--vehicle wheelset" in c else c for c in COMMANDS
    ],  # tests/cli draws all of the paper
)
def test_commands_work_as_written(command: str, cosim: Callable[..., Any]) -> None:
    Path("my_gyro.py").write_text(VARIANT)
    for name in re.findall(r"[\w.]+\.(?:fmu|ssp|toml)", command):  # what an earlier command of the README has made
        makers = [c for c in COMMANDS if c.split()[1] in ("export", "pack", "params")]
        making = [c for c in makers if name.split(".")[0] in c and c != command]
        if making and " -o " not in command:
            maker = min(making, key=lambda c: name not in c)  # the one that names the file itself, if there is one
            assert cosim(*shlex.split(maker)[1:])[0] == 0
    code, out, err = cosim(*shlex.split(command)[1:])
    assert code == 0, err
    assert out


def test_the_example_of_a_variant_is_short() -> None:
    assert len(VARIANT.splitlines()) < 40


def test_python_examples_run_as_written() -> None:
    for kind, text in BLOCKS:
        if kind == "python" and text != VARIANT:
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(compile(text, "README.md", "exec"), {})
            assert said.getvalue()


def test_the_table_of_signals_is_that_of_the_components() -> None:
    rows = re.findall(r"^\| (\w+:\w+) \| `(\w+)` \| ([\w, ]+) \| (\S+) \| (.*?) ?\|$", README, flags=re.MULTILINE)
    for spec in dict.fromkeys(row[0] for row in rows):
        shown = {row[1:] for row in rows if row[0] == spec}
        table = {
            (v.name, v.causality + (", state" if v.is_state else ""), v.unit, v.symbol)
            for v in catalogue.component(spec).variables
            if v.causality in ("input", "output")
        }
        assert shown == table


def test_what_make_run_prints_is_what_the_readme_shows(cosim: Callable[..., Any]) -> None:
    """Line by line, but for times and for numbers that flange contact makes chaotic."""
    makefile = (Path(__file__).parents[2] / "Makefile").read_text()
    command = re.search(r"^\t\S*/cosim (run .*)$", makefile, flags=re.MULTILINE)
    assert command is not None
    Path("results").mkdir()
    code, out, err = cosim(*shlex.split(command[1]))
    assert code == 0, err
    shown = next(text for kind, text in BLOCKS if kind == "text")
    printed = [line.split()[:4] if line.startswith(("took", "largest")) else line.split() for line in out.splitlines()]
    for line in shown.splitlines():
        if line != "...":
            if line.startswith("took"):
                assert any(words[:1] == ["took"] for words in printed)
            else:
                assert (line.split()[:4] if line.startswith("largest") else line.split()) in printed


@pytest.mark.parametrize("file", re.findall(r"\]\(((?!http)[^)#]+)\)", README))
def test_links_lead_somewhere(file: str) -> None:
    assert (Path(__file__).parents[2] / file).exists()
