"""A value of a vehicle file: a number with its unit, or a formula of named parameters. In the equations both are symbols.

    mass = "2000 kg"                      a literal: it becomes a parameter of the component
    x = "pivot_spacing / 2"               a formula: + - * / **, brackets, numbers, names of parameters
    x = 0                                 the constant 0, of any unit

A formula's dimension is worked out from those of its parameters; angles count as pure numbers there.
"""

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyro_cosim.component.units import unit

__all__ = ["ZERO", "Value", "formula", "is_literal"]

_LITERAL = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(\s*([A-Za-z%][\w.%/-]*)?|\s+1(/[\w.%-]+)?)\s*")
Dimension = tuple[int, ...]
PURE: Dimension = unit("1").dimension


@dataclass(frozen=True)
class Value:
    """A formula of parameters.

    Attributes
    ----------
    text : str
        As the file has it, for messages.
    names : tuple of str
        The parameters in it.
    tree : ast.expr
        The formula.
    """

    text: str
    names: tuple[str, ...]
    tree: ast.expr

    @property
    def is_zero(self) -> bool:
        """Whether it is the constant 0."""
        return isinstance(self.tree, ast.Constant) and self.tree.value == 0

    def negative(self) -> "Value":
        """The same with the other sign."""
        return self if self.is_zero else Value(f"-({self.text})", self.names, ast.UnaryOp(ast.USub(), self.tree))

    def of(self, s: Mapping[str, Any]) -> Any:
        """The value for numbers or symbols of the parameters, by name."""
        return _worked_out(self.tree, s)

    def dimension(self, units: Mapping[str, str]) -> Dimension:
        """Exponents of the SI base units, angles left out; ValueError where a sum adds unlike things."""
        return _dimension(self.tree, units)


def is_literal(text: str) -> bool:
    """Whether the text is one number with a unit or none, and no formula."""
    return _LITERAL.fullmatch(text) is not None


def formula(text: str) -> Value:
    """Read a formula; ValueError says what in it is not allowed."""
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError("must be a number with a unit or a formula of parameters") from None
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            names.append(node.id)
        elif isinstance(node, ast.Constant):
            if type(node.value) not in (int, float):
                raise ValueError("must hold numbers and names only")
        elif not isinstance(node, ast.BinOp | ast.UnaryOp | ast.operator | ast.unaryop | ast.expr_context):
            raise ValueError("must use + - * / ** and brackets only")
    _dimension(tree, dict.fromkeys(names, "1"))  # refuses other operators and powers
    return Value(text, tuple(dict.fromkeys(names)), tree)


def _worked_out(node: ast.expr, s: Mapping[str, Any]) -> Any:
    if isinstance(node, ast.Name):
        return s[node.id]
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.UnaryOp):
        inner = _worked_out(node.operand, s)
        return -inner if isinstance(node.op, ast.USub) else inner
    assert isinstance(node, ast.BinOp)
    left, right = _worked_out(node.left, s), _worked_out(node.right, s)
    if isinstance(node.op, ast.Add):
        return left + right
    if isinstance(node.op, ast.Sub):
        return left - right
    if isinstance(node.op, ast.Mult):
        return left * right
    if isinstance(node.op, ast.Div):
        return left / right
    return left**right


def _dimension(node: ast.expr, units: Mapping[str, str]) -> Dimension:
    if isinstance(node, ast.Name):
        return (*unit(units[node.id]).dimension[:-1], 0)
    if isinstance(node, ast.Constant):
        return PURE
    if isinstance(node, ast.UnaryOp):
        if not isinstance(node.op, ast.USub | ast.UAdd):
            raise ValueError("must use + - * / ** and brackets only")
        return _dimension(node.operand, units)
    assert isinstance(node, ast.BinOp)
    left, right = _dimension(node.left, units), _dimension(node.right, units)
    if isinstance(node.op, ast.Mult):
        return tuple(a + b for a, b in zip(left, right, strict=True))
    if isinstance(node.op, ast.Div):
        return tuple(a - b for a, b in zip(left, right, strict=True))
    if isinstance(node.op, ast.Pow):
        if not (isinstance(node.right, ast.Constant) and isinstance(node.right.value, int) and 0 <= node.right.value <= 4):
            raise ValueError("must have whole powers from 0 to 4")
        return tuple(a * node.right.value for a in left)
    if not isinstance(node.op, ast.Add | ast.Sub):
        raise ValueError("must use + - * / ** and brackets only")
    if left != right:
        raise ValueError("must add like to like")
    return left


ZERO = formula("0")
