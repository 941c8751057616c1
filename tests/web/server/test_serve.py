"""The command: where it listens, its token, and what it refuses to begin with."""

from __future__ import annotations

import socket

import httpx2 as httpx
import pytest

from meshmark.errors import InputError, OutputError, RegistryError
from meshmark.web.server.serve import _token, serve
from meshmark.web.server.settings import default_key_folder, is_loopback
from tests.web.server.served import serving


def test_bound_to_more_than_this_computer_a_token_is_printed_once_and_asked_for(tmp_path):
    with serving(tmp_path, "--host", "0.0.0.0") as server:
        token = server.token
        assert len(token) == 32
        assert httpx.get(f"{server.url}/api/server", trust_env=False).status_code == 401
        headers = {"authorization": f"Bearer {token}"}
        assert httpx.get(f"{server.url}/api/server", headers=headers, trust_env=False).status_code == 200
    assert server.process.returncode == 0
    assert list(server.temporary.iterdir()) == [], "the folder of jobs is removed at the end"
    assert token not in server.log.read_text()


def test_a_token_of_the_environment_is_used_and_a_short_one_refused(monkeypatch):
    monkeypatch.setenv("MESHMARK_TOKEN", "x" * 20)
    assert _token() == ("x" * 20, False)
    monkeypatch.setenv("MESHMARK_TOKEN", "x" * 15)
    with pytest.raises(InputError, match="15 characters, expected 16"):
        _token()
    monkeypatch.delenv("MESHMARK_TOKEN")
    first, second = _token(), _token()
    assert first[1]
    assert first[0] != second[0]
    assert len(first[0]) == 32


def test_a_port_that_is_taken_is_told_in_one_sentence(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OutputError, match=f"cannot listen on 127.0.0.1, port {port}"):
            serve(port=port, key_dir=tmp_path)


def test_a_registry_that_is_none_is_told_before_anything_is_served(tmp_path):
    with pytest.raises(RegistryError, match="there is no registry"):
        serve(port=0, key_dir=tmp_path, registry=str(tmp_path / "none.db"))


def test_the_default_folder_of_keys_is_in_the_configuration_of_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert default_key_folder() == tmp_path / "meshmark" / "keys"
    assert [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "0.0.0.0", "::", "10.0.0.1")] == [
        True, True, True, False, False, False,
    ]  # fmt: skip
