"""Reads arrays: NPY, NPZ, MAT before and of 7.3, HDF5."""
import io

import numpy

from endings import missing_package
from limits import check_zip
from table import Unusable, table_of_arrays


def package(name, file, what, debian):
    try:
        return __import__(name, fromlist=["_"])
    except ImportError:
        raise Unusable(f"{file}: {missing_package(what, name, debian)}") from None


def one_line(error):
    return " ".join(str(error).split())[:120] or type(error).__name__


def read_npy(file, data, within):
    try:
        if data[:2] == b"PK":
            check_zip(file, data)
        array = numpy.load(io.BytesIO(data), allow_pickle=False)
        arrays = dict(array) if isinstance(array, numpy.lib.npyio.NpzFile) else {"": array}
    except Unusable:
        raise
    except Exception as error:  # whatever its readers raise of bad bytes
        is_pickled = "allow_pickle" in str(error)
        reason = "pickled objects, which run code when they are read" if is_pickled else one_line(error)
        raise Unusable(f"{file}: cannot be read: {reason}: expected arrays of numbers") from None
    flat = []
    for name, array in arrays.items():
        if array.dtype.names:
            flat += [(f"{name}.{field}".lstrip("."), array[field], "") for field in array.dtype.names]
        else:
            flat.append((name or "column", array, ""))
    return table_of_arrays(file, "NumPy's arrays", flat, within)


def read_mat5(file, data, within):
    scipy_io = package("scipy.io", file, "MAT", "python3-scipy")
    try:
        content = scipy_io.loadmat(io.BytesIO(data), struct_as_record=False, squeeze_me=True)
    except Exception as error:
        raise Unusable(f"{file}: cannot be read: {one_line(error)}: expected a MAT file of version 5 to 7") from None
    arrays = []

    def walk(name, value):
        if hasattr(value, "_fieldnames"):
            for field in value._fieldnames:
                walk(f"{name}.{field}", getattr(value, field))
        elif isinstance(value, numpy.ndarray) and value.dtype.kind != "O":
            arrays.append((name, value, ""))
        elif isinstance(value, numpy.ndarray) and value.ndim == 1:
            for k, part in enumerate(value):
                walk(f"{name}[{k}]", part)

    for name, value in content.items():
        if not name.startswith("__"):
            walk(name, value)
    return table_of_arrays(file, "MAT", arrays, within)


def read_hdf5(file, data, within, is_matlab):
    what = "MAT 7.3" if is_matlab else "HDF5"
    h5py = package("h5py", file, what, "python3-h5py")
    arrays = []

    def visit(name, node):
        if isinstance(node, h5py.Dataset) and not name.startswith("#refs#") and node.shape:
            unit = node.attrs.get("units", node.attrs.get("unit", ""))
            unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
            if node.dtype.names:
                whole = node[()]
                arrays.extend((f"{name}.{field}", whole[field], unit) for field in node.dtype.names)
            elif node.dtype.kind in "iuf":
                # MATLAB writes its columns as rows.
                arrays.append((name, node[()].T if is_matlab else node[()], unit))

    try:
        with h5py.File(io.BytesIO(data), "r") as content:
            content.visititems(visit)
    except Exception as error:
        raise Unusable(f"{file}: cannot be read: {one_line(error)}: expected a whole file of {what}") from None
    return table_of_arrays(file, what, arrays, within)


