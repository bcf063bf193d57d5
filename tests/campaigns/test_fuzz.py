"""A short part of the fuzzing campaign, and findings of the long one as small cases."""

import sys

import fuzz
import pytest

from gyro_cosim.systems.scenario import read_toml

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the campaign forks")
INPUTS = 60


@pytest.fixture(scope="module")
def there(tmp_path_factory):
    return fuzz.doors(tmp_path_factory.mktemp("doors"))


def test_every_door_takes_its_good_input(there, tmp_path):
    for name, door in there.items():
        file = tmp_path / f"good{door.ending}"
        file.write_bytes(door.good)
        assert door.read(file) is not None, name


def test_mutated_input_is_read_or_refused_in_one_line(there, tmp_path):
    for name, door in there.items():
        count = max(2, round(INPUTS * door.share))
        outcomes, findings = fuzz.campaign(name, door, 7, count, tmp_path)
        assert findings == [], name
        assert outcomes["refused"] + outcomes["read"] == count, name
        assert outcomes["refused"] > count / 5, name  # the mistakes are mistakes


def test_the_campaign_finds_what_it_looks_for(there, tmp_path):
    def worse(file):
        data = file.read_bytes()
        if len(data) % 3 == 0:
            raise KeyError("x")
        if len(data) % 3 == 1:
            raise ValueError("two\nlines")
        raise ValueError("one")

    door = there["toml-scenario"]
    bad = fuzz.Door(b"[[event]]\n" + b"a" * 5, door.mutate, worse, ".toml")
    outcomes = {fuzz.judged(bad, tmp_path / "x.toml", (b"a" * n, False), "")[0] for n in range(3)}
    assert outcomes == {"traceback", "refused"}
    deaf = fuzz.Door(b"", door.mutate, lambda file: "something else", ".toml")
    assert fuzz.judged(deaf, tmp_path / "x.toml", (b"", True), "as before")[0] == "silent"


def test_toml_nested_without_end_is_refused(tmp_path):
    file = tmp_path / "deep.toml"
    file.write_text("a = " + "[" * 5000)
    with pytest.raises(ValueError, match="file must be TOML that is nested less deeply"):
        read_toml(file, "file")
