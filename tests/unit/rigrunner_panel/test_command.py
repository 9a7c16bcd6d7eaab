"""`rigrunner panel`, as far as it goes without being served."""

from __future__ import annotations

import sys

import pytest

from helpers_cli import call


def test_without_its_packages_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    called = call("panel", "--no-browser", "--runs", tmp_path)
    assert called.code == 3
    assert "the panel needs uvicorn" in called.err
    assert "pip install 'rigrunner[panel]'" in called.err


@pytest.mark.parametrize(
    "name",
    ["https://rig.example.org", "rig.example.org/", "rig example", "-rig", "rig:", "rig:port", "@"],
)
def test_a_public_name_is_that_of_a_host(name, tmp_path):
    words = ["--token", "correct-horse-battery", "--no-browser", "--runs", tmp_path]
    called = call("panel", f"--public-name={name}", *words)
    assert called.code == 2
    assert f"'{name}' is not the name of a host" in called.err
    assert "rig.example.org" in called.err


def test_who_comes_through_a_proxy_needs_a_token(tmp_path):
    words = ["--public-name", "rig.example.org", "--no-browser", "--runs", tmp_path]
    called = call("panel", *words)
    assert called.code == 2
    assert "lets others in, and there is no token" in called.err
    assert "RIGRUNNER_PANEL_TOKEN" in called.err


def test_a_port_that_is_taken_is_told(tmp_path):
    import socket  # noqa: PLC0415  (this test alone listens)

    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        called = call("panel", "--no-browser", "--port", str(port), "--runs", tmp_path)
    assert called.code == 2
    assert f"cannot listen on 127.0.0.1, port {port}" in called.err
    assert "--port 0" in called.err
