"""Times of day and dates in a column of times: 12:30:05,25; 2026-11-29T12:30:05.25Z; 29.11.2026
12:30:05 PM. They become seconds since the first row.
"""

from __future__ import annotations

import re
from datetime import date
from functools import lru_cache

_SECONDS_OF_DAY = 86_400.0
_DATE = r"(?P<date>\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.]\d{4})"
_TIME = r"(?:(?P<hours>\d{1,4}):)?(?P<minutes>\d{1,2}):(?P<seconds>\d{1,2}(?:[.,:]\d+)?)"
_HALF_AND_ZONE = r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>Z|[-+]\d{2}:?\d{2})?"
_INSTANT = re.compile(rf"(?:{_DATE}(?:[T;,]?\s*|\s+))?{_TIME}{_HALF_AND_ZONE}$")
_DATE_ALONE = re.compile(rf"{_DATE}$")

EXAMPLES_OF_CLOCK_TIMES = "12:30:05.25, 29.11.2026 12:30:05 or 2026-11-29T12:30:05Z"
"""Examples, for a sentence."""


def is_clock_time(text: str) -> bool:
    """Whether it is a time of day, a date or both.

    >>> is_clock_time("09:59:58,123"), is_clock_time("2026-11-29"), is_clock_time("1.5")
    (True, True, False)
    """
    return (":" in text and _INSTANT.match(text) is not None) or _DATE_ALONE.match(text) is not None


class ClockColumn:
    """A column of times, read row by row; it holds the first instant and the last.

    >>> column = ClockColumn()
    >>> [column.seconds(text) for text in ("23:59:59,5", "00:00:01,0")]
    [0.0, 1.5]
    """

    def __init__(self) -> None:
        self.first_text = ""
        self._first_date = ""
        self._first_seconds = 0.0
        self._last_seconds = 0.0
        self._midnights = 0

    def seconds(self, text: str) -> float | None:
        """Seconds from the first row of this column to a clock time such as "12:30:05,25" or
        "29.11.2026 12:30:05 PM"; None for a text that is no time.

        A time of day without a date that goes back by more than half a day is one of the next day.
        Time zones count; so do dates, in any of the usual orders.

        Raises
        ------
        ValueError
            For a date unlike the first one, where day and month of either can't be told from each
            other.
        """
        # Groups of the match: date, hours, minutes, seconds, half (AM or PM), zone; None if left
        # out.
        # `_INSTANT`: the pattern of a date and a time of day
        match = _INSTANT.match(text)
        if match is None:
            return None
        minutes_since_midnight = 60 * int(match["hours"] or 0) + int(match["minutes"])
        # Some loggers write hh:mm:ss:fff.
        seconds_of_minute = float(match["seconds"].replace(",", ".").replace(":", "."))
        seconds_since_midnight = 60.0 * minutes_since_midnight + seconds_of_minute
        am_or_pm = match["half"]
        if am_or_pm:
            # _SECONDS_OF_DAY: 86,400
            half_day = _SECONDS_OF_DAY / 2
            is_pm = am_or_pm[0] in "Pp"
            seconds_since_midnight = seconds_since_midnight % half_day + is_pm * half_day
        seconds_since_midnight -= _zone_offset(match["zone"])

        # The first row is where time is counted from: its text, date, and seconds since midnight.
        date_text = match["date"] or ""
        if not self.first_text:
            self.first_text = text
            self._first_date = date_text
            self._first_seconds = seconds_since_midnight
            self._last_seconds = seconds_since_midnight
        # Days since the first row, by dates or by midnights that have passed. A time of day is
        # compared with that of the row before, `_last_seconds`.
        days_since_first_row = 0
        if date_text and date_text != self._first_date:
            days_since_first_row = _day_number(date_text) - _day_number(self._first_date)
        elif not date_text:
            if seconds_since_midnight < self._last_seconds - _SECONDS_OF_DAY / 2:
                self._midnights += 1
            self._last_seconds = seconds_since_midnight
            days_since_first_row = self._midnights
        # To the tenth of a nanosecond: beyond is round-off of the subtraction.
        return round(
            days_since_first_row * _SECONDS_OF_DAY + (seconds_since_midnight - self._first_seconds),
            10,
        )


def _zone_offset(zone: str | None) -> float:
    """Seconds by which the clock of a time zone is ahead of UTC; 0 for no zone.

    >>> _zone_offset("+05:30"), _zone_offset("-0100"), _zone_offset("Z")
    (19800.0, -3600.0, 0.0)
    """
    if not zone or zone == "Z":
        return 0.0
    sign = -1.0 if zone[0] == "-" else 1.0
    hours_and_minutes = zone[1:].replace(":", "")
    return sign * (3600.0 * int(hours_and_minutes[:2]) + 60.0 * int(hours_and_minutes[2:]))


@lru_cache(maxsize=64)
def _day_number(text: str) -> int:
    """Number of the day of a date, its `text` being such as 2026-11-29, 29.11.2026 or 11/30/2026,
    counted from 1 January of the year 1.

    Raises
    ------
    ValueError
        For what is no date, and for dates with slashes whose day and month can't be told from each
        other.

    Examples
    --------
    >>> (
    ...     _day_number("30.11.2026") - _day_number("2026-11-29"),
    ...     _day_number("11/30/2026") - _day_number("29/11/2026"),
    ... )
    (1, 1)
    """
    numbers = [int(part) for part in re.split(r"[-/.]", text)]
    if numbers[0] > 31:
        year, month, day = numbers
    else:
        day, month, year = numbers
        if "/" in text and day <= 12 and month <= 12 and day != month:
            raise ValueError("day and month can't be told from each other: write 2026-11-29")
        if month > 12:
            day, month = month, day
    return date(year, month, day).toordinal()
