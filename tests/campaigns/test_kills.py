"""A short part of the campaign of kills, and whether it sees who stays."""

import subprocess
import sys
import time
from pathlib import Path

import kills
import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks at processes as Linux tells of them")
CAMPAIGN = Path(kills.__file__)


def test_whoever_outlives_a_command_is_seen_and_ended() -> None:
    code = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])"
    with subprocess.Popen([sys.executable, "-c", code], start_new_session=True) as process:
        assert kills.ended(process) == "1 processes are left"
        while kills.of_session(process.pid):
            time.sleep(0.01)
    with subprocess.Popen([sys.executable, "-c", ""], start_new_session=True) as process:
        assert kills.ended(process) == ""


@pytest.mark.slow
def test_a_run_that_is_killed_goes_on_to_the_same_bytes() -> None:
    command = [sys.executable, str(CAMPAIGN), "--kills", "4", "whole", "sweep"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "of 4 kills came before the end: 0 findings" in done.stdout
