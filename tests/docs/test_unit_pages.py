"""The pages about units are run as written, from top to bottom: files are written, commands give the exit code stated."""

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
NAMED = re.compile(r"(?:#|<!--) (\w+\.(?:py|toml|ssd))")


@pytest.mark.parametrize("page", ["bring-your-own-unit.md", "hil.md"])
def test_the_page_works_as_written(page: str, cosim: Callable[..., Any]) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    commands = 0
    for kind, block in re.findall(r"```(\w+)\n(.*?)```", text, flags=re.DOTALL):
        if kind in ("python", "toml", "xml"):
            name = NAMED.match(block)
            assert name is not None, block
            Path(name[1]).write_text(block, encoding="utf-8")
        elif kind == "sh":
            for line in block.splitlines():
                command, _, remark = line.partition("   # ")
                code, out, err = cosim(*shlex.split(command)[1:])
                assert code == int(remark.removeprefix("exit code ") or 0), f"{command}\n{err}"
                assert out
                commands += 1
    assert commands >= 6
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", text):
        assert (DOCS / link).exists()


def test_the_rig_page_names_every_parameter_of_the_rig() -> None:
    from gyro_cosim.gyro_unit.rig_parameters import RIG_SMALL

    text = (DOCS / "hil.md").read_text(encoding="utf-8")
    for parameter in RIG_SMALL:
        assert f"`{parameter.name}`" in text
