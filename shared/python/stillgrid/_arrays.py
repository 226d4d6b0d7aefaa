"""Arrays of a caller as the library reads them: not copied where they are so already."""
import operator
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[numpy.float64]


def floats(values: ArrayLike, name: str, *shape: int | None) -> Floats:
    """Float64, C-contiguous, of that shape; None is any length. ValueError says what was expected."""
    array: Any = values
    if not (type(array) is numpy.ndarray and array.dtype == numpy.float64 and _is_whole(array)):
        array = _numbers(values, name, "fiub", "numbers")
        array = numpy.require(array, numpy.float64, ["C", "A"])
    _check_shape(array, name, shape)
    return array  # type: ignore[no-any-return]


def indices(values: ArrayLike, name: str, *shape: int | None) -> NDArray[numpy.uint32]:
    """Uint32, C-contiguous, of that shape; None is any length. ValueError says what was expected."""
    array: Any = values
    if not (type(array) is numpy.ndarray and array.dtype == numpy.uint32 and _is_whole(array)):
        array = _numbers(values, name, "iu", "whole numbers")
        if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
            raise ValueError(f"{name}: {array.min()} to {array.max()}: expected 0 to 4294967295")
        array = numpy.require(array, numpy.uint32, ["C", "A"])
    _check_shape(array, name, shape)
    return array  # type: ignore[no-any-return]


def address(array: "NDArray[Any] | None") -> int | None:
    return None if array is None else array.ctypes.data


def _is_whole(array: Any) -> bool:
    return bool(array.flags.c_contiguous and array.flags.aligned)


def _numbers(values: ArrayLike, name: str, kinds: str, expected: str) -> Any:
    try:
        array = numpy.asarray(values)
    except ValueError:  # rows of several lengths
        raise ValueError(f"{name}: expected an array of {expected}") from None
    if array.size == 0 and type(values) is not numpy.ndarray:
        array = array.astype(numpy.uint32)  # an empty list is of no type yet
    if array.dtype.kind not in kinds:
        raise ValueError(f"{name}: dtype {array.dtype}: expected {expected}")
    return array


def _check_shape(array: Any, name: str, shape: tuple[int | None, ...]) -> None:
    if array.ndim == len(shape) and all(wanted in (None, has) for wanted, has in zip(shape, array.shape)):
        return
    text = ", ".join("N" if wanted is None else str(wanted) for wanted in shape)
    raise ValueError(f"{name}: shape {array.shape}: expected ({text}{',' if len(shape) == 1 else ''})")


def whole(value: int, name: str, bits: int) -> int:
    """A number that the library takes as an unsigned one of so many bits."""
    try:
        number = operator.index(value)
    except TypeError:
        raise ValueError(f"{name}: {value!r}: expected a whole number") from None
    if not 0 <= number < 2**bits:
        raise ValueError(f"{name}: {number}: expected 0 to {2**bits - 1}")
    return number
