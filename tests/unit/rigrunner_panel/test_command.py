"""Errors of `rigrunner panel` before it serves."""

from __future__ import annotations

import sys

import pytest

from helpers_cli import call


def test_missing_package_is_reported_with_install_hint(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    called = call("panel", "--no-browser", "--runs", tmp_path)
    assert called.code == 3
    assert "the panel needs uvicorn" in called.err
    assert "pip install 'rigrunner[panel]'" in called.err


@pytest.mark.parametrize(
    "name",
    ["https://rig.example.org", "rig.example.org/", "rig example", "-rig", "rig:", "rig:port", "@"],
)
def test_public_name_must_be_a_host_name(name, tmp_path):
    words = ["--token", "correct-horse-battery", "--no-browser", "--runs", tmp_path]
    called = call("panel", f"--public-name={name}", *words)
    assert called.code == 2
    assert f"'{name}' is not the name of a host" in called.err
    assert "rig.example.org" in called.err


def test_public_name_requires_a_token(tmp_path):
    words = ["--public-name", "rig.example.org", "--no-browser", "--runs", tmp_path]
    called = call("panel", *words)
    assert called.code == 2
    assert "lets others in, and there is no token" in called.err
    assert "RIGRUNNER_PANEL_TOKEN" in called.err


def test_port_in_use_is_reported(tmp_path):
    import socket  # noqa: PLC0415  (this test alone listens)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        called = call("panel", "--no-browser", "--port", str(port), "--runs", tmp_path)
    assert called.code == 2
    assert f"cannot listen on 127.0.0.1, port {port}" in called.err
    assert "--port 0" in called.err
