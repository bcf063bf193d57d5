"""What a run says about how right it is, besides the energy on its bonds: certificate, adaptive steps, states held twice."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.table import Table

from ..accuracy import certificate
from ..accuracy.accumulated import GlobalError, global_error
from ..accuracy.certificate import Certificate
from ..errors import RunError
from ..master import Run
from ..network import Network
from ..network.redundancy import redundant_states
from .common import finite, progress
from .summary import certificate_document, certificate_words


@dataclass(frozen=True)
class Certainty:
    """What is known. failure : why there is no certificate although one was wanted; empty otherwise."""

    certificate: Certificate | None = None
    whole: GlobalError | None = None
    redundant: tuple[str, ...] = ()
    failure: str = ""


def certainty(network: Network, run: Run, end: float, *, certify: bool) -> Certainty:
    """Find it out; the network is still open, and is run again where that is needed. The run itself stands whatever happens."""
    adapts = run.adaptive is not None
    if run.status != "done" or not (certify or adapts):
        return Certainty()
    redundant = tuple(str(r) for r in redundant_states(network))  # where the run ended, before the network starts anew
    if certify:
        with progress("certifying") as show:
            try:
                return Certainty(certificate=certificate.certify(network, run, end, progress=show), redundant=redundant)
            except RunError as error:
                return Certainty(redundant=redundant, failure=f"no certificate: over shorter steps {error}")
    with progress("estimating the error") as show:
        return Certainty(whole=global_error(network, run, end, progress=show), redundant=redundant)


def certainty_document(run: Run, known: Certainty) -> dict[str, Any]:
    """It as JSON holds it."""
    told: dict[str, Any] = {}
    if known.certificate is not None:
        told["certificate"] = certificate_document(known.certificate)
    if known.redundant:
        told["redundant_states"] = list(known.redundant)
    if run.adaptive is not None:
        h = np.diff(run.trajectory.t)
        whole = known.whole
        told["adaptive"] = {
            "tolerance": run.adaptive.tolerance, "estimate": run.adaptive.estimate, "meaning": run.adaptive.meaning,
            "shortest_step": finite(float(h.min(initial=np.inf))), "longest_step": float(h.max(initial=0.0)),
            "global_error": None if whole is None else {
                "how": whole.how,
                "errors": {e.name: {"largest": e.largest, "end": e.end, "size": e.size, "unit": e.unit} for e in whole.errors},
            },
        }  # fmt: skip
    return told


def certainty_words(run: Run, known: Certainty) -> list[str | Table]:
    """It in words."""
    lines: list[str | Table] = []
    if run.adaptive is not None:
        lines.append(run.adaptive.meaning)
    if known.whole is not None:
        lines.append(_whole_words(known.whole))
    lines += [f"WARNING: {text}" for text in known.redundant]
    return lines + ([] if known.certificate is None else certificate_words(known.certificate))


def _whole_words(whole: GlobalError) -> str:
    worst = whole.worst
    if worst is None:
        return f"no estimate of the error over the whole run: {whole.how}"
    share = worst.largest / worst.size if worst.size > 0.0 else 0.0
    at = f"{worst.largest:.2g} {worst.unit}".strip()
    size = f"{share:.2g} of the size of {worst.name} ({at})"
    return f"estimated error over the whole run: at most {size}; {whole.how}"
