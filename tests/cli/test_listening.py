"""Commands within another program: what they say is heard, and nothing is printed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from meshmark.cli.listening import heard_by, listener
from meshmark.cli.main import main


class Ear:
    def __init__(self) -> None:
        self.stages, self.remarks, self.answers = [], [], []

    def stage(self, label: str) -> None:
        self.stages.append(label)

    def remark(self, line: str) -> None:
        self.remarks.append(line)

    def answer(self, words: str, fields: Mapping[str, Any]) -> None:
        self.answers.append((words, fields))


def test_a_listener_hears_stages_and_the_answer_in_words_and_as_fields(files, cli):
    line = ["extract", str(files.marked), "--key", str(files.key), "--json"]
    printed, ear = cli(*line), Ear()
    with heard_by(ear):
        heard = cli(*line)
    assert (heard.code, heard.out, heard.err) == (printed.code, "", "")
    ((words, fields),) = ear.answers
    assert words.startswith("Present: ")
    assert fields["id"] in printed.out
    assert ear.stages == ["looking for the mark"]
    assert listener() is None


def test_a_listener_hears_an_error_as_its_fields_and_its_sentence(tmp_path):
    ear = Ear()
    with heard_by(ear):
        code = main(["info", str(tmp_path / "none.ply"), "--json"])
    assert code == 2
    assert ear.answers[0][1]["error"]["file"] == str(tmp_path / "none.ply")
    assert ear.remarks == [f"meshmark: {ear.answers[0][1]['error']['message']}"]
