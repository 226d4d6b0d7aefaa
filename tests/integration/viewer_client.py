"""Asks scene_viewer over HTTP, as its page does."""
import http.client
import json
import struct
import urllib.parse

import numpy

TYPES = {"f32": "<f4", "f64": "<f8", "u32": "<u4"}


def decode(message):
    """A binary answer: its head, and its arrays by name."""
    length, = struct.unpack_from("<I", message)
    head = json.loads(message[4:4 + length])
    offset, arrays = 4 + length, {}
    for array in head.pop("arrays"):
        arrays[array["name"]] = numpy.frombuffer(message, TYPES[array["type"]], array["count"],
                                                 offset)
        offset += arrays[array["name"]].nbytes
    if length % 4 or offset != len(message):
        raise ValueError(f"a head of {length} bytes, {offset} of {len(message)} told")
    return head, arrays


class Page:
    """A viewer's answers, by one connection that is kept."""

    def __init__(self, address):
        """address: as scene_viewer prints it, http://HOST:PORT/KEY/."""
        self.host, _, key = address.removeprefix("http://").rstrip("/").partition("/")
        self.root = f"/{key}"
        self.session = ""  # "": that the viewer was started for
        self._connection = http.client.HTTPConnection(self.host, timeout=10)

    def close(self):
        self._connection.close()

    def ask(self, path, method="GET", headers=(), body=None):
        """Status, headers and body. path: from the key on, as /api/status."""
        path = self.root + path
        try:
            self._connection.request(method, path, body, dict(headers))
            response = self._connection.getresponse()
        except (http.client.HTTPException, ConnectionError):  # one that rested was closed
            self._connection.close()
            self._connection.request(method, path, body, dict(headers))
            response = self._connection.getresponse()
        return response.status, response.headers, response.read()

    def _get(self, path):
        status, _, body = self.ask(path + ("&" if "?" in path else "?") + "session=" + urllib.parse.quote(self.session))
        if status != 200:
            raise ValueError(f"{path}: {status} {body}")
        return body

    def status(self):
        return json.loads(self._get("/api/status"))

    def scene(self):
        return json.loads(self._get("/api/scene"))

    def frame_bytes(self, number="latest"):
        return self._get(f"/api/frame?number={number}")

    def frame(self, number="latest"):
        return decode(self.frame_bytes(number))

    def move_mouse(self, holder, **members):
        """Status and line of an answer to the mouse of a page."""
        message = {"holder": holder, "position_m": [0, 0, 0.03], "orientation_xyzw": [0, 0, 0, 1], "buttons": 0}
        status, _, body = self.ask("/api/mouse", "POST", body=json.dumps(message | members))
        return status, body.decode()

    def ticks(self, first=0, most=65536):
        return decode(self._get(f"/api/ticks?from={first}&most={most}"))[1]
