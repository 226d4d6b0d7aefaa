"""Names that recordings of earlier versions use, and today's; C++ has them in shared/files/old_names.hpp."""

COLUMNS = {"generation": "snapshot_id"}
FLAGS = {"cut": "truncated"}


def columns_of_today(header):
    return [COLUMNS.get(name, name) for name in header]


def flags_of_today(text):
    """Of one row's column flags."""
    return "|".join(FLAGS.get(name, name) for name in text.split("|"))
