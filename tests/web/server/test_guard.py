"""What is refused before it reaches the application, and the headers of every response."""

from __future__ import annotations

from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from meshmark.web.server.guard import COOKIE, session_value
from meshmark.web.server.service import make_service
from meshmark.web.server.settings import Settings
from tests.counting import some

TOKEN = "a token of more than sixteen characters"


@pytest.fixture
def make(tmp_path: Path):
    """Make a client of a server with these settings; its jobs are not run."""

    def made(base: str = "http://127.0.0.1:8000", **settings: object) -> TestClient:
        (tmp_path / "keys").mkdir(exist_ok=True)
        return TestClient(make_service(Settings(key_folder=tmp_path / "keys", **settings)), base_url=base)

    return made


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:8000", "[::1]:8000", "LOCALHOST:99", "localhost."])
def test_a_server_goes_by_the_names_of_this_computer(make, host):
    assert make().get("/api/server", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "localhost@evil.example", "10.0.0.1", "[", ""]
)
def test_another_name_in_the_host_header_is_refused(make, host):
    answer = make().get("/api/server", headers={"host": host})
    assert answer.status_code == 421
    assert answer.json()["error"]["kind"] == "forbidden"


def test_bound_to_a_network_a_server_goes_by_addresses_and_by_the_names_it_is_given(make):
    client = make(host="0.0.0.0", token=TOKEN, hosts=("models.example",))
    codes = [
        client.get("/", headers={"host": host}).status_code
        for host in ("192.168.0.7:8000", "[fd00::7]", "models.example", "evil.example")
    ]
    assert codes == [200, 200, 200, 421]


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 201),
        ({"origin": "http://127.0.0.1:8000"}, 201),
        ({"origin": "http://127.0.0.1:8001"}, 403),
        ({"origin": "https://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": "http://["}, 403),
        ({"sec-fetch-site": "same-origin"}, 201),
        ({"sec-fetch-site": "cross-site"}, 403),
        ({"sec-fetch-site": "same-site"}, 403),
    ],
)
def test_a_post_from_a_page_of_another_site_is_refused(make, headers, status):
    assert make().post("/api/keys", json={"label": "a"}, headers=headers).status_code == status


def test_a_page_of_another_site_may_not_read_an_answer_or_frame_the_page(make):
    client = make()
    for path in ("/", "/pages/main.js", "/api/server", "/nothing", "/api/jobs/none"):
        headers = client.get(path, headers={"origin": "https://evil.example"}).headers
        assert "access-control-allow-origin" not in headers
        assert headers["x-content-type-options"] == "nosniff"
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["cross-origin-resource-policy"] == "same-origin"


def test_with_a_token_every_request_to_the_api_needs_it(make):
    client = make(host="0.0.0.0", token=TOKEN)
    paths = some(
        client.get("/api/openapi.json", headers={"authorization": f"Bearer {TOKEN}"}).json()["paths"], 8
    )
    asked = ["/api/openapi.json", *(path for path in paths if path != "/api/session")]
    for path in some(asked, least=8):
        for method in ("GET", "POST", "DELETE"):
            assert client.request(method, path).status_code == 401, (method, path)
    assert client.get("/").status_code == 200, "the page asks for the token"


@pytest.mark.parametrize(
    ("header", "status"),
    [
        (f"Bearer {TOKEN}", 200),
        (f"bearer {TOKEN}", 200),
        (TOKEN, 401),
        (f"Bearer {TOKEN[:-1]}", 401),
        (f"Bearer {TOKEN}x", 401),
        ("Bearer ", 401),
        (f"Basic {TOKEN}", 401),
    ],
)
def test_the_token_in_a_header(make, header, status):
    client = make(host="0.0.0.0", token=TOKEN)
    assert client.get("/api/server", headers={"authorization": header}).status_code == status


def test_a_browser_presents_the_token_once_and_keeps_a_cookie_without_it(make):
    client = make(host="0.0.0.0", token=TOKEN)
    assert client.post("/api/session", json={"token": "wrong"}).status_code == 401
    answer = client.post("/api/session", json={"token": TOKEN})
    assert answer.status_code == 204
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "samesite=strict" in cookie.lower()
    assert TOKEN not in cookie
    assert client.get("/api/server").status_code == 200
    other = make(host="0.0.0.0", token=TOKEN + "2")
    other.cookies.set(COOKIE, session_value(TOKEN))
    assert other.get("/api/server").status_code == 401


@pytest.mark.parametrize("told", [True, False], ids=["with its length", "without"])
def test_an_upload_above_the_limit_is_refused_while_it_arrives(make, told):
    client, taken = make(upload_bytes=1000), []

    def parts():
        for _ in range(100):
            taken.append(1)
            yield bytes(100)

    body = bytes(10_000) if told else parts()
    kind = {"content-type": "multipart/form-data; boundary=x"}
    answer = client.post("/api/jobs", content=body, headers=kind)
    assert answer.status_code == 413
    assert answer.json()["error"]["kind"] == "too_large"


def test_every_refusal_has_the_form_of_the_errors_of_the_command_line(make):
    client = make()
    answers = [
        client.get("/nothing"),
        client.put("/api/keys"),
        client.get("/api/jobs/none"),
        client.post("/api/keys", content=b"{"),
        client.post("/api/keys", json={"label": "../x"}),
        client.get("/api/registry/copies"),
        client.post("/api/jobs", content=b"nonsense", headers={"content-type": "multipart/form-data"}),
    ]
    assert [answer.status_code for answer in answers] == [404, 405, 404, 422, 422, 404, 400]
    for answer in answers:
        assert answer.json().keys() == {"error"}
        assert answer.json()["error"].keys() == {"kind", "message", "file"}
        assert answer.json()["error"]["message"]
    assert answers[1].headers["allow"] == "GET, POST"
