"""The polynomials of our mathematics, computed in high precision: what c/polynomials.h holds.

    python -m gyro_cosim.fmus.polynomials            writes the file anew
    python -m gyro_cosim.fmus.polynomials --check    exit code 1 if it differs from what would be written

Each polynomial is the best one in the sense of Chebyshev, by Remez's exchange on a grid, in 60 digits: the largest error over the
interval, weighted with what the polynomial is multiplied by, is as small as it can be. Then its coefficients are rounded to
double. Needs mpmath (the extra `dev`).
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["FILE", "POLYNOMIALS", "Polynomial", "coefficients", "text", "truncation"]

FILE = Path(__file__).parent / "c" / "polynomials.h"
DIGITS = 60
PLACES = 600  # of the grid on which extrema are looked for
EXCHANGES = 30  # of places, at most; four or five do


@dataclass(frozen=True)
class Polynomial:
    """What is approximated by a polynomial, and where.

    Attributes
    ----------
    name : str
        Of the C function, behind gc_polynomial_.
    meaning : str
        The function as a formula.
    function : callable
        (mpmath, z) -> value, smooth over the interval; never called at z = 0.
    low, high : str
        The interval, as expressions of mpmath.
    terms : int
        Number of coefficients.
    weight : int
        Errors count times |z|^weight.
    """

    name: str
    meaning: str
    function: Callable[[Any, Any], Any]
    low: str
    high: str
    terms: int
    weight: int


def _sin(m: Any, z: Any) -> Any:
    return (m.sin(m.sqrt(z)) / m.sqrt(z) - 1) / z


def _cos(m: Any, z: Any) -> Any:
    return (m.cos(m.sqrt(z)) - 1 + z / 2) / z**2


def _atan(m: Any, z: Any) -> Any:
    return (m.atan(m.sqrt(z)) / m.sqrt(z) - 1) / z


def _asin(m: Any, z: Any) -> Any:
    return (m.asin(m.sqrt(z)) / m.sqrt(z) - 1) / z


def _exp(m: Any, r: Any) -> Any:
    return (m.exp(r) - 1 - r) / r**2


def _log(m: Any, z: Any) -> Any:
    return (2 * m.atanh(m.sqrt(z)) / m.sqrt(z) - 2) / z


def _log_tail(m: Any, z: Any) -> Any:
    return (_log(m, z) - m.mpf(2) / 3 - 2 * z / 5) / z**2


def _erf(m: Any, z: Any) -> Any:
    return m.erf(m.sqrt(z)) / m.sqrt(z) - 1


def _erfc(m: Any, t: Any) -> Any:
    x = (1 + 2 * t) / (1 - t)
    return m.erfc(x) * m.exp(x * x)


EIGHTH_TURN, HALF_LN2 = "pi / 4 * 1.001", "log(2) / 2 * 1.001"  # a little beyond: reduction rounds
POLYNOMIALS = (
    Polynomial("sin", "(sin(r) / r - 1) / z, z = r^2", _sin, "0", f"({EIGHTH_TURN})**2", 6, 1),
    Polynomial("cos", "(cos(r) - 1 + z / 2) / z^2, z = r^2", _cos, "0", f"({EIGHTH_TURN})**2", 6, 2),
    Polynomial("atan", "(atan(u) / u - 1) / z, z = u^2", _atan, "0", "mpf(9) / 64", 10, 1),
    Polynomial("asin", "(asin(u) / u - 1) / z, z = u^2", _asin, "0", "mpf(1) / 4", 13, 1),
    Polynomial("exp", "(exp(r) - 1 - r) / r^2", _exp, f"-{HALF_LN2}", HALF_LN2, 11, 2),
    Polynomial("log", "(log((1 + s) / (1 - s)) / s - 2) / z, z = s^2", _log, "0", "mpf('0.02945')", 7, 1),
    Polynomial("log_tail", "the one before less 2/3 + 2/5 z, over z^2", _log_tail, "0", "mpf('0.02945')", 7, 2),
    Polynomial("erf", "erf(x) / x - 1, z = x^2", _erf, "0", "1", 14, 0),
    Polynomial("erfc", "erfc(x) exp(x^2), z = (x - 1) / (x + 2), x from 1 to 6", _erfc, "0", "mpf(5) / 8", 21, 0),
)


def coefficients(polynomial: Polynomial) -> list[float]:
    """The coefficients, lowest power first, rounded to double."""
    import mpmath as m

    n = polynomial.terms
    with m.workdps(DIGITS):
        grid = _grid(m, polynomial)
        values, weights = [_value(m, polynomial, z) for z in grid], [abs(z) ** polynomial.weight for z in grid]
        chosen = [round(k * (len(grid) - 1) / n) for k in range(n + 1)]
        for _ in range(EXCHANGES):
            rows = [[grid[i] ** k for k in range(n)] + [(-1) ** j / weights[i]] for j, i in enumerate(chosen)]
            *c, level = m.lu_solve(m.matrix(rows), m.matrix([values[i] for i in chosen]))
            error = [w * (v - _sum(c, z)) for z, v, w in zip(grid, values, weights, strict=True)]
            extrema = _extrema(error, n + 1)
            if extrema == chosen or max(map(abs, error)) < abs(level) * 1.001:
                break
            chosen = extrema
        return [float(a) for a in c]


def _grid(m: Any, polynomial: Polynomial) -> list[Any]:
    """Places in the interval, denser at its ends, but for 0, where the formula cannot be evaluated."""
    low, high = (eval(end, dict(vars(m))) * m.mpf(1) for end in (polynomial.low, polynomial.high))
    places = [(low + high) / 2 - (high - low) / 2 * m.cos(m.pi * k / PLACES) for k in range(PLACES + 1)]
    return [z for z in places if abs(z) > high / 10**6]


def _value(m: Any, polynomial: Polynomial, z: Any) -> Any:
    with m.workdps(2 * DIGITS):  # the formulas take differences
        return polynomial.function(m, z)


def _sum(c: list[Any], z: Any) -> Any:
    return sum(a * z**k for k, a in enumerate(c))


def _extrema(error: list[Any], count: int) -> list[int]:
    """Where the error is largest, once between two changes of its sign; the `count` in a row whose ends are larger."""
    places: list[int] = []
    for i, e in enumerate(error):
        if places and (e > 0) == (error[places[-1]] > 0):
            if abs(e) > abs(error[places[-1]]):
                places[-1] = i
        else:
            places.append(i)
    while len(places) > count:
        places.pop(0 if abs(error[places[0]]) < abs(error[places[-1]]) else -1)
    if len(places) < count:
        raise ArithmeticError(f"the error must change its sign {count - 1} times, it does {len(places) - 1} times")
    return places


def truncation(polynomial: Polynomial) -> float:
    """Largest weighted difference of function and polynomial, its coefficients rounded, over the interval."""
    import mpmath as m

    c = coefficients(polynomial)
    with m.workdps(DIGITS):
        return float(max(abs(z) ** polynomial.weight * abs(_value(m, polynomial, z) - _sum(c, z)) for z in _grid(m, polynomial)))


def _chain(c: list[float], variable: str) -> str:
    """Horner's form of a polynomial in `variable`, in C."""
    expression = repr(c[-1])
    for i, value in enumerate(reversed(c[:-1])):
        expression = f"{value!r} + {variable} * " + (f"({expression})" if i else expression)
    return expression


def text() -> str:
    """The file as it must be."""
    parts = [
        "/* Written by `python -m gyro_cosim.fmus.polynomials`: not to be edited. Even and odd powers are summed apart,",
        "   which halves how long one waits for the result. */",
        "",
        "#ifndef POLYNOMIALS_H",
        "#define POLYNOMIALS_H",
        "",
        '#include "real.h"',
        "",
    ]
    for polynomial in POLYNOMIALS:
        c = coefficients(polynomial)
        parts += [
            f"/* {polynomial.meaning} */",
            f"static inline real gc_polynomial_{polynomial.name}(real z) {{",
            "    real w = z * z;",
            f"    real even = {_lines(_chain(c[0::2], 'w'))};",
            f"    real odd = {_lines(_chain(c[1::2], 'w'))};",
            "    return even + z * odd;",
            "}",
            "",
        ]
    return "\n".join([*parts, "#endif", ""])


def _lines(expression: str) -> str:
    """Broken before each factor but the first, where it is long."""
    words, lines = expression.split(" + "), [""]
    for word in words:
        piece = word if not lines[0] else " + " + word
        if len(lines[-1]) + len(piece) > 100:
            lines.append("")
        lines[-1] += piece
    return "\n       ".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Write or check; the exit code."""
    parser = argparse.ArgumentParser(description="Compute the polynomials of fmus/c/polynomials.h.")
    parser.add_argument("--check", action="store_true", help="say whether the file is as it must be, and write nothing")
    wanted = text()
    if parser.parse_args(arguments).check:
        if FILE.read_text(encoding="utf-8") != wanted:
            print(f"{FILE.name} differs from what {Path(__file__).name} computes: write it anew", file=sys.stderr)
            return 1
        return 0
    FILE.write_text(wanted, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
