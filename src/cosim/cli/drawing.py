"""Figures as commands write them: they say which command drew them, and never take another file's place in silence."""

from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from .common import tell, writable
from .given import repeated
from .provenance import versions

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def foreign(image: Path) -> bool:
    """Whether a file is there that does not say that cosim drew it."""
    from .. import figures

    return image.is_file() and not figures.made_here(image)


def check(image: Path | None) -> None:
    """Refuse, before any work, a figure that cannot be written afterwards; say which file of somebody else it will replace."""
    from .. import figures

    writable(image, figures.check_format)
    if image is not None and foreign(image):
        tell([f"{str(image)!r} does not say that cosim drew it, and will be replaced"])


def save(made: "Figure", image: Path) -> Path:
    """Write a figure that tells the command and the versions that drew it."""
    from .. import figures

    used = versions() | {"matplotlib": metadata.version("matplotlib")}
    told = ", ".join(f"{name} {version}" for name, version in used.items() if name != "machine")
    return figures.save(made, image, f"{repeated()}\n{told}")
