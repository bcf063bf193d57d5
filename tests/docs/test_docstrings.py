"""The public interface says what its arguments are, in sections that tools read."""

import inspect
import re

import pytest

import gyro_cosim

PUBLIC = [name for name in gyro_cosim.__all__ if not name.startswith("__")]


def sections(text: str) -> dict[str, str]:
    """Numpydoc sections of a docstring by name."""
    found = re.split(r"^(\w[\w ]*)\n-{3,}\n", inspect.cleandoc(text), flags=re.MULTILINE)
    return dict(zip(found[1::2], found[2::2], strict=True))


@pytest.mark.parametrize("name", PUBLIC)
def test_every_parameter_of_the_public_interface_is_explained(name: str) -> None:
    what = getattr(gyro_cosim, name)
    assert what.__doc__
    if inspect.isclass(what) and issubclass(what, Exception) and "__init__" not in vars(what):
        return  # as every exception, it takes its message
    parameters = inspect.signature(what).parameters
    told = sections(what.__doc__)
    explained = told.get("Parameters", "") + told.get("Attributes", "")
    rows = {
        word for row in re.findall(r"^(\w[\w, *]*)(?: :|$)", explained, flags=re.MULTILINE) for word in re.findall(r"\w+", row)
    }
    assert set(parameters) <= rows, f"{name}: {sorted(set(parameters) - rows)}"


@pytest.mark.parametrize("name", [n for n in PUBLIC if inspect.isfunction(getattr(gyro_cosim, n))])
def test_every_function_of_the_public_interface_says_what_it_returns(name: str) -> None:
    assert "Returns" in sections(getattr(gyro_cosim, name).__doc__)


def test_names_that_are_not_public_are_not_there() -> None:
    assert not hasattr(gyro_cosim, "Part")
    with pytest.raises(AttributeError, match=r"gyro_cosim\.Part is called gyro_cosim\.SystemComponent since 0\.2\.0"):
        _ = gyro_cosim.Part
    assert set(dir(gyro_cosim)) >= set(gyro_cosim.__all__)
