"""The page as one HTML file: it loads nothing from anywhere, and nothing in its data can become part of its code."""

import html
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from gyro_cosim.component.whole_files import write_whole

from ..master import Run
from ..systems import catalogue
from ..trajectory import Trajectory
from . import contents
from .bundling import PAGE, Bundle, bundle


def write_report(file: str | Path, run: Run, told: contents.Told) -> None:
    """Write the page of a run. The file appears complete or not at all.

    Parameters
    ----------
    file : str or Path
        An .html file.
    run : Run
        Whole or in part.
    told : Told
        What is known of it besides.

    Raises
    ------
    ValueError
        The file does not end in .html.
    RuntimeError
        The page's script is not there and cannot be built.
    """
    _written(Path(file), lambda: contents.document(run, told))


def write_recorded(file: str | Path, runs: Mapping[str, Trajectory], told: contents.Told) -> None:
    """Write the page of runs of which only the recorded signals are known: the first, with the others over it.

    Parameters
    ----------
    file : str or Path
        An .html file.
    runs : mapping of str to Trajectory
        By what they are called; at least one.
    told : Told
        What is known besides.

    Raises
    ------
    ValueError
        The file does not end in .html, or there is no run.
    RuntimeError
        The page's script is not there and cannot be built.
    """
    if not runs:
        raise ValueError("a report needs at least one run, got none")
    _written(Path(file), lambda: contents.recorded(runs, told))


def _written(file: Path, document: Callable[[], dict[str, Any]]) -> None:
    check_format(file)
    made = bundle(catalogue.cache_folder())
    text = page(document(), made)
    write_whole(file, text)


def check_format(file: Path) -> None:
    """ValueError where the file is none that a report can be written to."""
    if file.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"report must be an .html file, got {str(file)!r}")


def page(document: dict[str, Any], made: Bundle) -> str:
    """The HTML text."""
    template = (PAGE / "index.html").read_text(encoding="utf-8")
    parts = {
        "title": html.escape(str(document["title"])),
        "connect": "; connect-src 'self'" if document.get("live") else "",  # to the run that it shows, and nowhere else
        "style": made.style,
        "data": _inert(json.dumps(_nulled(document), ensure_ascii=False, allow_nan=False)),
        "worker": _inert(json.dumps(made.worker)),
        "script": made.script.replace("</script", "<\\/script"),
    }
    before, *rest = template.split("{{")
    pieces = [before]
    for piece in rest:
        name, _, after = piece.partition("}}")
        pieces += [parts[name], after]
    return "".join(pieces)


def _inert(text: str) -> str:
    """JSON that no HTML parser takes for markup, whatever names it holds."""
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _nulled(value: Any) -> Any:
    """The same with null for numbers that JSON has not."""
    if isinstance(value, float):
        return value if abs(value) <= 1.7976931348623157e308 else None
    if isinstance(value, dict):
        return {key: _nulled(item) for key, item in value.items()}
    return [_nulled(item) for item in value] if isinstance(value, list | tuple) else value
