"""Finds out what a file is by its first bytes, whatever its name, and reads it."""
import csv
import zlib

import isolated
import limits
from binary_tables import read_hdf5, read_mat5, read_npy
from mcap_file import MAGIC
from mcap_table import read_mcap
from table import Unusable
from text_table import read_text


def read(file, within=None, delimiter=None):
    data = limits.bytes_of(file)
    if data[:2] == b"\x1f\x8b":
        try:
            data = limits.gunzipped(file, data)
        except (OSError, EOFError, zlib.error) as error:
            raise Unusable(f"{file}: cannot be unpacked: {error}: expected a whole .gz") from None
    if data[:6] == b"\x93NUMPY" or data[:4] == b"PK\x03\x04":
        return read_npy(file, data, within)
    if data[:10] == b"MATLAB 5.0":
        return isolated.call(file, read_mat5, data, within)
    if data[:10] == b"MATLAB 7.3" or data[:8] == b"\x89HDF\r\n\x1a\n":
        return isolated.call(file, read_hdf5, data, within, data[:6] == b"MATLAB")
    if data[:8] == MAGIC:
        return read_mcap(file, data, within)
    if data[:9] == b"#ROSBAG V" or data[:15] == b"SQLite format 3":
        raise Unusable(f"{file}: a bag of ROS: expected one of ROS 2 as MCAP, which 'ros2 bag convert' makes")
    if within:
        raise Unusable(f"--within: value '{within}': expected no such option for a file of text")
    try:
        return read_text(file, data, delimiter)
    except csv.Error as error:
        raise Unusable(f"{file}: cannot be read: {error}: expected lines of text") from None
