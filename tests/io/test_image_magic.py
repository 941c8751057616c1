"""Images are known by their first bytes, and other files are none."""

from __future__ import annotations

import io

import pytest
from PIL import Image

from meshmark.io.image_magic import HEAD, is_image


@pytest.mark.parametrize(
    "kind", ["PNG", "JPEG", "GIF", "BMP", "TIFF", "PPM", "WEBP", "ICO", "DDS", "TGA", "JPEG2000"]
)
def test_what_pillow_writes_is_an_image(kind):
    packed = io.BytesIO()
    Image.new("RGB", (20, 16), (10, 200, 30)).save(packed, kind)
    assert is_image(packed.getvalue()[:HEAD])


@pytest.mark.parametrize(
    "head",
    [
        b"",
        b"root:x:0:0:root:/root:/bin/bash\n",
        b"-----BEGIN OPENSSH PRIVATE KEY-----",
        b"meshmark key 1\n0123456789abcdef",
        b"PK\x03\x04\x14\0\0\0\x08\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
        b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0>\0\x01\0\0\0",
        b"SQLite format 3\0\x10\0\x01\x01\0 ",
        b"BMW is a car maker; this is no bitmap",
        b"P4ssw0rd",
        b'{"private": true}',
    ],
)
def test_private_files_are_none(head):
    assert not is_image(head)
