"""Figures of files: several runs over one another, as vector graphics for a paper, in nobody else's place."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

from gyro_cosim import figures
from gyro_cosim.trajectory import Trajectory

RUN = ("run", "wheel-pair", "--stop", "0.1", "--in-process")
MILLIMETRE = 72 / 25.4  # points
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def runs(cosim: Callable[..., Any]) -> Callable[..., Any]:
    """The command line, beside two runs of the wheel pair, a.csv and b.csv."""
    assert cosim(*RUN, "--output", "a.csv", "--set", "gyro.rotor_speed=200rpm")[0] == 0
    assert cosim(*RUN, "--output", "b.csv", "--set", "gyro.rotor_speed=0")[0] == 0
    return cosim


def words(image: str) -> list[str]:
    """Every text of an .svg."""
    return ["".join(text.itertext()).strip() for text in ET.parse(image).iter(f"{SVG}text")]


@pytest.mark.parametrize(("columns", "width"), [("1", 88.0), ("2", 180.0)])
def test_a_figure_for_a_paper_is_a_vector_graphic_as_wide_as_its_columns(runs, columns: str, width: float) -> None:
    told = runs("plot", "a.csv", "b.csv", "vehicle.y*", "--style", "paper", "--columns", columns, "-o", "f.svg", "-o", "f.pdf")
    assert told[0] == 0, told
    root = ET.parse("f.svg").getroot()
    assert float(root.get("width", "").removesuffix("pt")) == pytest.approx(width * MILLIMETRE, abs=0.1)
    assert root.find(f".//{SVG}image") is None
    assert Path("f.pdf").read_bytes().startswith(b"%PDF")


def test_runs_are_called_by_what_tells_their_commands_apart_and_axes_have_units(runs) -> None:
    assert runs("plot", "a.csv", "b.csv", "vehicle.yaw_angle", "--over", "vehicle.lateral_displacement", "-o", "f.svg")[0] == 0
    shown = words("f.svg")
    assert any("rotor_speed=200rpm" in word for word in shown)
    assert any("rotor_speed=0" in word for word in shown)
    assert any("[rad]" in word for word in shown)
    assert any("[m]" in word for word in shown)
    assert runs("plot", "?.csv", "vehicle.yaw_angle", "--label", "with", "--label", "without", "-o", "g.svg")[0] == 0
    assert {"with", "without"} <= set(words("g.svg"))


def test_names_are_shown_as_they_stand(runs) -> None:
    """To matplotlib dollars begin a formula, and a first underscore means: not in the legend."""
    Path("a.csv").rename("$x$.csv")
    Path("b.csv").rename("_b.csv")
    for words_of in (("vehicle.yaw_angle",), ()):
        assert runs("plot", "$x$.csv", "_b.csv", *words_of, "--label", "$x$", "--label", "_b", "-o", "f.svg")[0] == 0
        assert {"$x$", "_b"} <= set(words("f.svg"))


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_a_figure_of_ours_is_drawn_again_and_nobody_elses_is_replaced(runs, ending: str) -> None:
    image = Path(f"f.{ending}")
    for _ in range(2):
        assert runs("plot", "a.csv", "-o", str(image))[0] == 0
    figure, axes = pyplot.subplots()
    axes.plot([0, 1])
    figure.savefig(image)
    pyplot.close(figure)
    theirs = image.read_bytes()
    code, _, err = runs("plot", "a.csv", "-o", str(image))
    assert (code, image.read_bytes()) == (2, theirs)
    assert err == f"cosim: '{image}' must be a figure that cosim drew, or --overwrite is needed: it does not say so\n"
    assert runs("plot", "a.csv", "-o", str(image), "--overwrite")[0] == 0
    assert figures.made_here(image)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("a.csv", "--style", "papier"), "--style"),
        (("a.csv", "--columns", "2"), "--columns has no effect without --style paper, got 2"),
        (("a.csv", "--style", "paper", "--columns", "3"), "--columns must be 1 or 2, got 3"),
        (("a.csv", "b.csv", "--label", "one"), "--label must name each of 2 files differently"),
        (("empty.csv",), "'empty.csv' must hold at least one row, holds none"),
        (("a.csv", "c.csv"), "file 'c.csv' must exist"),
        (("a.csv", "--over", "distance"), "'distance'"),
        (("a.csv", "-o", "f.docx"), "plot file must end in one of"),
    ],
)
def test_what_cannot_be_drawn_is_told_in_a_line(runs, options: tuple[str, ...], told: str) -> None:
    Path("empty.csv").write_text("time,y\n")
    code, _, err = runs("plot", *options)
    assert code == 2
    assert told in err
    assert err.count("\n") == 1


def test_a_long_run_keeps_its_peaks() -> None:
    t = np.linspace(0.0, 100.0, 200_001)
    values = np.sin(t)[:, None].copy()
    values[123_457] = 9.0
    long = Trajectory(t=t, names=("c.y",), units=("m",), values=values)
    overlay = figures.Overlay.of({"run": long}, ["c.y"], figures.TIME)
    (line,) = overlay.panels[0].lines
    assert len(line.y) < 20_000
    assert line.y.max() == 9.0
    assert line.y.min() == values.min()
    assert "only the first, last, least and greatest" in overlay.notes[0]
