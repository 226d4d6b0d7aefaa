"""Names that recordings of earlier versions use, and today's; C++ has them in shared/files/old_names.hpp."""

COLUMNS = {"generation": "snapshot_id", "tx_Nm": "tx_N_m", "ty_Nm": "ty_N_m", "tz_Nm": "tz_N_m"}
FLAGS = {"cut": "truncated"}


def columns_of_today(header: list[str]) -> list[str]:
    return [COLUMNS.get(name, name) for name in header]


def given_twice(header: list[str]) -> str | None:
    """A column that stands there by its earlier name and today's, or twice by one; None where there is none."""
    names = columns_of_today(header)
    return next((name for name in COLUMNS.values() if names.count(name) > 1), None)


def flags_of_today(text: str) -> str:
    """Of one row's column flags."""
    return "|".join(FLAGS.get(name, name) for name in text.split("|"))
