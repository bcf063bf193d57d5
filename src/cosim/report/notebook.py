"""The page of a run in a notebook, beside the code that made the run."""

import html
from collections.abc import Sequence

from ..master import Run
from ..systems import catalogue
from . import contents
from .bundling import bundle
from .writing import page

__all__ = ["Shown"]

HEIGHT = 720  # px


class Shown:
    """What `run.show()` gives: a notebook shows it in a frame of its own, from which nothing reaches the notebook.

    Parameters
    ----------
    run : Run
        What is shown.
    variants : sequence of str
        Of the part that people exchange, those that the page's menu offers.
    height : int
        Of the frame, px.

    Raises
    ------
    RuntimeError
        The page's script is not there and cannot be built.
    """

    def __init__(self, run: Run, *, variants: Sequence[str] = (), height: int = HEIGHT) -> None:
        told = contents.Told(command="", variants=variants)
        self.page = page(contents.document(run, told), bundle(catalogue.cache_folder()))
        self._height = height

    def _repr_html_(self) -> str:
        source = html.escape(self.page, quote=True)
        return (
            f'<iframe sandbox="allow-scripts allow-downloads" srcdoc="{source}" width="100%" height="{self._height}" '
            'style="border: 0" title="The page of a run"></iframe>'
        )
