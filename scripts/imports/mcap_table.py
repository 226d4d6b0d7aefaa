"""A topic of an MCAP file as a table, a row a message; with it the topics that have the very same stamps."""
import json
import re
import struct

import numpy

import cdr
import mcap_file
from table import Column, Table, Unusable

# Whose messages are in SI units: ROS by its REP 103, Foxglove's likewise.
IN_SI_UNITS = re.compile(r"(stillgrid\.|foxglove\.|geometry_msgs/|nav_msgs/|sensor_msgs/).*")
SI_UNITS = {"position": "m", "translation": "m", "point": "m", "force": "N", "force_N": "N", "rendered_force_N": "N"}


def read_mcap(file, data, within):
    recording = mcap_file.read(file, data)
    topics = recording.topics
    if not topics:
        raise Unusable(f"{file}: no message: expected a topic with positions")
    name = within or max(topics, key=lambda name: rank(topics[name]))
    if name not in topics:
        raise Unusable(f"{file}: --within: value '{within}': expected a topic, one of {', '.join(sorted(topics))}")
    if not is_readable(topics[name]):
        topic = topics[name]
        by = f" by a schema in '{topic.schema_encoding}'" if topic.encoding == "cdr" else ""
        raise Unusable(f"{file}: topic {name}: messages encoded as '{topic.encoding}'{by}: expected json, or cdr by a "
                       "schema in 'ros2msg'")
    stamps_ns = topics[name].stamps()
    taken = [name] + [other for other, topic in sorted(topics.items())
                      if other != name and is_readable(topic) and topic.stamps() == stamps_ns]
    columns = [Column("log_time", numpy.array(stamps_ns, numpy.int64), "ns")]
    for each in taken:
        columns += columns_of(file, each, topics[each])
    notes = [] if recording.is_whole else ["the file was cut off; read up to there"]
    others = [f"{other} ({len(topic.messages)})" for other, topic in sorted(topics.items()) if other not in taken]
    if others:
        notes.append(f"left out: topics {', '.join(others)}; --within TOPIC takes another")
    # A recording of haptic_server is in the scene's frame; what reads trajectories knows it by this line.
    about = [("scene", recording.metadata["stillgrid"].get("scene", ""))] if "stillgrid" in recording.metadata else []
    return Table(file, f"MCAP, topic {' with '.join(taken)}", columns, notes=notes, about=about)


def is_readable(topic):
    return topic.encoding == "json" or topic.encoding == "cdr" and topic.schema_encoding == "ros2msg"


def rank(topic):
    """Which topic is looked at first: one that can be read, of places, with the most messages."""
    names_place = re.search(r"pose|transform|odometry|point$", topic.schema_name, re.I)
    return is_readable(topic), bool(names_place), len(topic.messages)


def columns_of(file, name, topic):
    try:
        types = cdr.definitions(topic.schema.decode("utf-8")) if topic.encoding == "cdr" else None
        rows = [flat(message) if types is None else cdr.flat(types, topic.schema_name, message)
                for _, message in topic.messages]
    except (ValueError, RecursionError, struct.error) as error:
        raise Unusable(f"{file}: topic {name}: a message cannot be read: {error}: expected {topic.encoding}") from None
    names = [key for key in rows[0] if all(key in row for row in rows)]
    return [Column(key, numpy.array([row[key] for row in rows]), unit_of(topic, key)) for key in names]


def unit_of(topic, column):
    parts = column.split(".")
    return SI_UNITS.get(parts[-2], "") if len(parts) > 1 and IN_SI_UNITS.fullmatch(topic.schema_name) else ""


def flat(message):
    """The numbers of a message in JSON: pose.position.x, data[0]."""
    found = {}

    def walk(name, value):
        if isinstance(value, dict):
            for key, part in value.items():
                walk(f"{name}.{key}" if name else key, part)
        elif isinstance(value, list) and len(value) <= 64:
            for k, part in enumerate(value):
                walk(f"{name}[{k}]", part)
        elif isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 2**63:
            found[name] = value

    try:
        walk("", json.loads(message))
    except ValueError:
        raise ValueError(f"value '{message[:40]!r}'") from None
    return found
