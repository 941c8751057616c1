"""Requests that schemathesis makes of the server's own OpenAPI description: none of them breaks it."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings

from tests.counting import some
from tests.web.server.served import serving

ADDRESSES = {
    "/api/jobs", "/api/jobs/{job}", "/api/jobs/{job}/files/{name}", "/api/jobs/{job}/result",
    "/api/jobs/{job}/view", "/api/keys", "/api/registry/copies", "/api/server", "/api/session",
}  # fmt: skip


@pytest.fixture(scope="module")
def other_server(tmp_path_factory):
    """A server of its own: keys are made on it."""
    with serving(tmp_path_factory.mktemp("described")) as served:
        yield served


@pytest.fixture(scope="module")
def schema(other_server):
    schemathesis = pytest.importorskip("schemathesis", reason="schemathesis is not installed")
    return schemathesis.openapi.from_url(f"{other_server.url}/api/openapi.json")


def test_no_request_breaks_the_server(schema):
    asked = []
    for result in some(schema.get_all_operations(), least=len(ADDRESSES)):
        operation = result.ok()

        @settings(max_examples=6, suppress_health_check=list(HealthCheck), database=None)
        @given(case=operation.as_strategy())
        def holds(case):
            answer = case.call()
            asked.append(answer.status_code)
            assert answer.status_code < 500, (case.as_curl_command(), answer.text)

        holds()
    assert len(asked) > 30


def test_every_address_and_every_refusal_is_described(other_server):
    with other_server.client() as client:
        description = client.get("/api/openapi.json").json()
    assert set(description["paths"]) == ADDRESSES
    for path, methods in some(description["paths"].items()):
        for method, operation in some(methods.items()):
            assert operation["summary"], (path, method)
            assert "422" in operation["responses"], (path, method)
