"""How right is a result?

accumulated     error over a whole run with adaptive steps, whose tolerance is one of each step by itself
certificate     of a run: estimated coupling error of every output, observed order, stability margin
convergence     true errors over a ladder of macro steps, and the observed order
monolith        the reference: the same equations as one system, without coupling
figures         the ladder drawn
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .accumulated import GlobalError, global_error
    from .certificate import Certificate, OutputError, Stability, certify, margin
    from .convergence import Convergence, Ladder, converge
    from .monolith import Monolith

__all__ = [
    "Certificate", "Convergence", "GlobalError", "Ladder", "Monolith", "OutputError", "Stability", "certify",
    "converge", "global_error", "margin",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load what is asked for: a certificate needs no equations, which take a while to import."""
    from importlib import import_module

    for module in ("accumulated", "certificate", "convergence", "monolith"):
        if name in __all__:
            loaded = import_module(f".{module}", __name__)
            if hasattr(loaded, name):
                return getattr(loaded, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
