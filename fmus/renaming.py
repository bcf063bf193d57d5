"""CasADi's own C code with our mathematics: what it calls from the C library is renamed to what c/mathematics.h has.

CasADi prints functions that are no SX graphs, such as implicit steps with their linear algebra and Newton iteration, itself.
"""

import re

from .printing import CALLED, UnknownOperationError

__all__ = ["with_our_mathematics"]

OURS = frozenset(CALLED) - {"constpow", "if_else_zero", "lt", "le", "eq", "ne", "and", "or", "not", "sign"}
OTHERS = (  # the rest of <math.h>
    "cbrt", "erfc", "exp2", "fdim", "fma", "frexp", "ilogb", "ldexp", "lgamma", "llrint", "llround", "log10", "log2",
    "logb", "lrint", "lround", "modf", "nan", "nearbyint", "nextafter", "remquo", "rint", "round", "scalbn", "tgamma", "trunc",
)  # fmt: skip
CALL = re.compile(rf"(?<![\w.>])({'|'.join(sorted({*OURS, *OTHERS}))})(?=\s*\()")


def with_our_mathematics(text: str, what: str) -> str:
    """CasADi's C code with calls of c/mathematics.h, which it must include.

    Parameters
    ----------
    text : str
        As CasADi's code generator writes it.
    what : str
        Whose code it is, for the message.

    Returns
    -------
    str
        The code.

    Raises
    ------
    UnknownOperationError
        If it calls a function of <math.h> that we have not; the message names it.
    """

    def renamed(call: re.Match[str]) -> str:
        if call[1] not in OURS:
            raise UnknownOperationError(f"{what}: our mathematics has no {call[1]!r}")
        return CALLED[call[1]]

    return CALL.sub(renamed, text)
