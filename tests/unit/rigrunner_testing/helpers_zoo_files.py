"""For each check of the kit, a format, an importer or a listener that fails it."""

from __future__ import annotations

import contextlib
import html
import itertools
import socket
import struct
import tempfile
import threading
import time

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.api.events import Alarm, Samples
from rigrunner.api.hooks import (
    EventSinkRecord,
    ImporterExample,
    ImporterRecord,
    ReportFormatRecord,
)
from rigrunner.api.importing import Column, NotInFileError
from unit.rigrunner_testing.helpers_zoo import registry_of

OPENED = []


def page(report):
    """Return a page that passes all checks."""
    return f"<p>{html.escape(report.result.run.inputs['specimen'])}</p>".encode()


def unescaped(report):
    return f"<p>{report.result.run.inputs['specimen']}</p>".encode()


def with_picture(report):
    return page(report) + b'<img alt="logo" src="https://example.org/logo.png">'


def looks_up_a_font(report):
    with contextlib.suppress(OSError):  # the page is made without a network too
        socket.getaddrinfo("fonts.invalid", 443)
    return page(report)


def keeps_a_file(report):
    OPENED.append(tempfile.TemporaryFile())  # noqa: SIM115  (kept open is the point)
    return page(report)


COUNT = itertools.count()
FORMATS = {
    "can_be_made": None,
    "makes_a_file": lambda report: page(report).decode(),
    "same_run_same_bytes": lambda report: page(report) + str(next(COUNT)).encode(),
    "names_are_escaped": unescaped,
    "nothing_is_fetched": with_picture,
    "leaves_nothing_open": keeps_a_file,
}
"""By check, the format that fails it."""


def format_registry(writer):
    record = ReportFormatRecord(
        name="page", help="A page.", suffix=".html", factory=lambda _: writer
    )
    return registry_of("report_format", record)


def listener(event):
    """Do nothing, which passes all checks."""


def crashes_on_an_alarm(event):
    if isinstance(event, Alarm):
        raise KeyError(event.source)


def is_slow(event):
    if isinstance(event, Alarm):
        time.sleep(0.15)


def is_slow_later(event):
    if isinstance(event, Samples) and event.block.first_sample:
        time.sleep(0.15 if event.block.first_sample == 10_000 else 0)


def zeroes(event):
    if isinstance(event, Samples):
        event.block.channels["tester.torque"][:] = 0.0


def zeroes_the_angle(event):
    if isinstance(event, Samples):
        event.block.channels["tester.angle"][:] = 0.0


def starts_a_thread(event):
    if isinstance(event, Alarm):
        threading.Thread(target=threading.Event().wait, args=(20,), daemon=True).start()


SINKS = {
    "can_be_made": None,
    "takes_every_event": crashes_on_an_alarm,
    "comes_back_at_once": is_slow,
    "leaves_samples_alone": zeroes,
    "lets_go_when_the_run_ends": starts_a_thread,
}
"""By check, the listener that fails it."""


def sink_registry(sink):
    record = EventSinkRecord(name="sink", help="A sink.", factory=lambda _: sink)
    return registry_of("event_sink", record)


class Table:
    """Reads columns separated by blanks; it passes all checks."""

    def read(self, path, columns, group):
        if group:
            raise NotInFileError(f"{path}: there are no groups")
        try:
            names, *rows = [line.split() for line in self.text(path).splitlines()]
        except ValueError as error:
            raise DataError(f"{path} holds no table") from error
        return {channel: self.column(path, names, rows, name) for channel, name in columns.items()}

    def text(self, path):
        try:
            return path.read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError) as error:
            raise DataError(f"{path} cannot be read: {error}") from error

    def column(self, path, names, rows, name):
        if name not in names:
            raise NotInFileError(f"{path} has no column '{name}'", hint=f"there are: {names}")
        try:
            values = np.array([float(row[names.index(name)]) for row in rows])
        except (ValueError, IndexError) as error:
            raise DataError(f"{path}: {error}") from error
        if not np.isfinite(values).all():
            raise DataError(f"{path}: not finite")
        return Column(values)


class RaisesOsErrors(Table):
    def text(self, path):
        return path.read_text(encoding="latin-1")


class RaisesStructErrors(Table):
    def text(self, path):
        if path.is_file():
            struct.unpack("<4s", path.read_bytes()[:4])
        return super().text(path)


class KeepsItsFiles(Table):
    def text(self, path):
        if path.is_file():
            OPENED.append(path.open("rb"))
        return super().text(path)


class Doubles(Table):
    def column(self, path, names, rows, name):
        return Column(2 * super().column(path, names, rows, name).values)


class RaisesKeyErrors(Table):
    def column(self, path, names, rows, name):
        if name not in names:
            raise KeyError(name)
        return super().column(path, names, rows, name)


class TakesHalfARow(Table):
    def column(self, _path, names, rows, name):
        return Column(np.array([float(row[names.index(name)]) for row in rows if len(row) > 0]))


IMPORTERS = {
    "can_be_made": lambda: None,
    "missing_file_refused": RaisesOsErrors,
    "foreign_files_refused": RaisesStructErrors,
    "closes_its_files": KeepsItsFiles,
    "examples_are_read": Doubles,
    "missing_columns_are_named": RaisesKeyErrors,
    "cut_files_refused": TakesHalfARow,
}
"""By check, the importer that fails it."""
EXAMPLE = ImporterExample(
    source="by hand",
    content=b"torque angle\n1.5 0.25\n-2.0 0.5\n",
    columns={"t": "torque", "a": "angle"},
    values={"t": (1.5, -2.0), "a": (0.25, 0.5)},
)


def importer_registry(importer, example=EXAMPLE):
    record = ImporterRecord(
        name="table", help="A table.", factory=lambda _: importer(), examples=(example,)
    )
    return registry_of("importer", record)
