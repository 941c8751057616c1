"""Real processes that run a command: limits, killing, and their end with the server."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import time

import pytest

from meshmark.web.server.command_process import CommandProcess, ProcessDied


def message(folder, command, memory: int = 4 << 30) -> dict:
    return {"folder": str(folder), "command": command, "memory": memory, "large": False, "registry": None}


def test_a_command_is_run_in_its_folder_with_its_stages_and_its_answer(tmp_path, pebble_file):
    told = []

    async def scenario() -> dict:
        process = await CommandProcess.start()
        found = await process.run(message(tmp_path, ["info", str(pebble_file), "--json"]), told.append)
        assert not process.is_alive
        return found

    found = asyncio.run(scenario())
    assert found["code"] == 0
    assert found["answer"]["vertices"] == 1514
    assert told[0] == {"ready": True}


def test_a_model_for_which_the_memory_of_a_job_is_too_small_is_an_error_of_the_job(tmp_path):
    """An STL of 4 million triangles, of which the disk holds the header alone."""
    with (tmp_path / "large.stl").open("wb") as file:
        file.write(bytes(80) + (4_000_000).to_bytes(4, "little"))
        file.truncate(84 + 50 * 4_000_000)

    async def scenario() -> dict:
        process = await CommandProcess.start()
        return await process.run(
            message(tmp_path, ["info", "large.stl", "--json"], 400 << 20), lambda _: None
        )

    error = asyncio.run(scenario())["answer"]["error"]
    assert error["kind"] in ("memory", "input")
    assert "memory" in error["message"] or "too large" in error["message"]


def test_a_killed_process_says_so(tmp_path):
    async def scenario() -> None:
        process = await CommandProcess.start()
        asyncio.get_running_loop().call_later(0.1, process.kill)
        await process.run(message(tmp_path, ["demo", "--out", "demo"]), lambda _: None)

    with pytest.raises(ProcessDied, match="was killed"):
        asyncio.run(scenario())


def test_a_process_ends_with_the_one_that_started_it(tmp_path):
    code = (
        "import asyncio, os\n"
        "from meshmark.web.server.command_process import CommandProcess\n"
        "async def main():\n"
        "    process = await CommandProcess.start()\n"
        "    print(process._process.pid, flush=True)\n"
        "    os._exit(9)\n"
        "asyncio.run(main())\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    pid, deadline = int(ran.stdout), time.monotonic() + 30
    while _lives(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not _lives(pid)


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    with open(f"/proc/{pid}/stat") as file:  # noqa: PTH123
        return file.read().rpartition(")")[2].split()[0] != "Z"
