"""Arithmetic in a study's `[derived]`: numbers, the names of axes, + - * / **, and the functions of a pocket calculator."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from scenes import InputError

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    **{
        name: getattr(math, name)
        for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "radians", "degrees")
    },
    "abs": abs,
    "min": min,
    "max": max,
}
_LONGEST = 500


def evaluate(text: str, names: Mapping[str, Any]) -> float:
    """The value of an expression in `names`, a finite number.

    Raises
    ------
    InputError
        For anything but arithmetic, an unknown name, or a value that is no finite number.

    >>> evaluate("pi*(h/2)**2 + max(1, w)", {"h": 2.0, "w": 3.0})
    6.14159...
    """
    if len(text) > _LONGEST:
        raise InputError(f"{text[:30]!r}... is longer than {_LONGEST} characters; give a name of its own to a part of it")
    try:
        value = _value(ast.parse(text, mode="eval").body, {"pi": math.pi, **names})
        number = float(value)
    except (SyntaxError, ArithmeticError, ValueError, TypeError, RecursionError, MemoryError) as reason:
        raise InputError(f"{text!r} can't be evaluated: {reason}") from reason
    if not math.isfinite(number):
        raise InputError(f"{text!r} is {number}: a finite number is needed")
    return number


def _value(node: ast.expr, names: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.Name(id=name):
            if name not in names:
                raise InputError(f"{name!r} is not known: it is neither an axis nor derived above; known: {', '.join(names)}")
            return _number(name, names[name])
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, names)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _value(operand, names)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _BINARY[type(op)](_value(left, names), _value(right, names))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in _FUNCTIONS:
            return _FUNCTIONS[name](*(_value(arg, names) for arg in args))
    raise InputError(f"{ast.unparse(node)!r} is refused: numbers, names, + - * / **, and {', '.join(_FUNCTIONS)} are what there is")


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name!r} is {value!r}: arithmetic needs a number")
    return float(value)
