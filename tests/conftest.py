"""Fixtures for all rooms: built FMUs are shared by the whole session, and no test leaves files behind."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fmu_opening import built  # noqa: F401 (a fixture)

from gyro_cosim.cli import main


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """FMUs of this session are built from this tree's sources and kept apart from the user's.

    The workers of pytest-xdist share them: each has a folder of its own below that of the session.
    """
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GYRO_COSIM_CACHE", str(shared / "cache"))
        yield


@pytest.fixture
def cosim(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """The command line: cosim("run", ...) -> (exit code, standard output, standard error), in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main(arguments)
        said = capsys.readouterr()
        return code, said.out, said.err

    return call


@pytest.fixture
def cosim_json(cosim: Callable[..., Any]) -> Callable[..., dict[str, Any]]:
    """The command line with --json, which must succeed; returns the document."""

    def call(*arguments: str) -> dict[str, Any]:
        code, out, err = cosim(*arguments, "--json")
        assert code == 0, err
        return json.loads(out)

    return call
