"""Tables of recipients: names, and the names of files that they become."""

from __future__ import annotations

import pytest

from meshmark.errors import InputError
from meshmark.registry.recipients import read_recipients


def test_names_become_names_of_files_that_differ(tmp_path):
    names = [
        "Ann Lee",
        "ann  lee",
        "../../etc/passwd",
        "Zoë",
        "CON",
        "ann_lee-2",
        "***",
        "a" * 300,
        "b@c.org",
    ]
    table = tmp_path / "people.csv"
    table.write_text("mail,recipient\n" + "".join(f'x,"{name}"\n' for name in names), encoding="utf-8")
    found = read_recipients(table)
    assert [each.name for each in found] == names
    stems = [each.stem for each in found]
    assert stems == [
        "ann_lee", "ann_lee-2", "etc_passwd", "zoë", "_con", "ann_lee-2-2", "_", "a" * 80, "b@c.org",
    ]  # fmt: skip
    assert read_recipients(table) == found


def test_a_table_of_a_spreadsheet_is_read(tmp_path):
    (tmp_path / "people.csv").write_bytes('\ufeffrecipient\r\n"Ann\nLee, Ltd."\r\nBob\r\n'.encode())
    assert [each.name for each in read_recipients(tmp_path / "people.csv")] == ["Ann\nLee, Ltd.", "Bob"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"name\nAnn\n", "has no column 'recipient', expected a CSV file whose first line names the columns"),
        (b"", "has no column 'recipient'"),
        (b"recipient\n", "names no recipients, expected one a line"),
        (b"recipient\nAnn\nBob\nAnn \n", "line 4: 'Ann' is in line 2 already"),
        (b"recipient,mail\nAnn,x\n,y\n", "line 3: the column 'recipient' is empty"),
        (b"recipient\n\xff\n", "is no text, expected CSV in UTF-8"),
        (None, "cannot read"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused_in_one_sentence(tmp_path, content, message):
    table = tmp_path / "people.csv"
    if content is not None:
        table.write_bytes(content)
    with pytest.raises(InputError, match=message) as refused:
        read_recipients(table)
    assert "people.csv" in str(refused.value)
    assert "\n" not in str(refused.value)
