"""The secret key: 32 random bytes, kept in a file that only its owner can read, and never shown."""

from __future__ import annotations

import contextlib
import hashlib
import hmac
import os
import re
import secrets
from math import log10
from pathlib import Path
from typing import NoReturn

from meshmark.errors import InputError, KeyFileError, OutputError

__all__ = ["LOG10_GUESS", "Key", "is_key_file"]

KEY_BYTES = 32
LOG10_GUESS = -8 * KEY_BYTES * log10(2.0)
"""log10 of the chance that a guess is a given key, about -77: no evidence is better than a key is secret."""
HEADER = "meshmark key 1"
_ANY_HEADER = b"meshmark key "
_FILE = re.compile(rf"{HEADER}\n([0-9a-f]{{{2 * KEY_BYTES}}})\n".encode())
# Enough to see that a file is too long to be a key, without reading a large file into memory.
_READ_LIMIT = 4 * KEY_BYTES
# Permissions of the group and of all others.
_OTHERS = 0o077
_DOMAIN = b"meshmark subkey 1\0"
_DERIVED = b"meshmark derived key 1\0"
_FINGERPRINT, _FINGERPRINT_BYTES = "public fingerprint", 8


class Key:
    """A secret key; cannot be changed, printed or pickled, and compares in constant time.

    Every use of the key goes through `subkey`, so that no two parts of meshmark share random numbers.

    Parameters
    ----------
    secret : bytes
        The 32 bytes of the key; `Key.generate` draws them, `Key.load` reads them from a file.

    Raises
    ------
    InputError
        `secret` is not of 32 bytes.
    """

    __slots__ = ("_secret",)
    _secret: bytes

    def __init__(self, secret: bytes) -> None:
        """Make a key of 32 bytes; raises `InputError` for any other length."""
        if not isinstance(secret, bytes) or len(secret) != KEY_BYTES:
            raise InputError(f"a key is made of {KEY_BYTES} bytes")
        object.__setattr__(self, "_secret", secret)

    @classmethod
    def generate(cls) -> Key:
        """Draw a new key from the operating system's random source."""
        return cls(secrets.token_bytes(KEY_BYTES))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, force: bool = False) -> Key:
        """Read a key file.

        Parameters
        ----------
        path : str or path-like
            The file, as `save` writes it.
        force : bool
            Take a file that other users can read, too.

        Returns
        -------
        Key
            The key of the file.

        Raises
        ------
        KeyFileError
            The file cannot be read, or by other users as well, or holds no key; the message never quotes what it
            holds.
        """
        name = os.fspath(path)
        try:
            with Path(path).open("rb") as file:
                content, mode = file.read(_READ_LIMIT), os.fstat(file.fileno()).st_mode
        except OSError as error:
            raise KeyFileError(
                f"cannot read the key file {name}: {error.strerror or 'error'}", file=name
            ) from None
        match = _FILE.fullmatch(content)
        if match is None:
            raise KeyFileError(
                f"{name} is not a meshmark key, expected the line '{HEADER}' and a line of "
                f"{2 * KEY_BYTES} lower-case hexadecimal digits",
                file=name,
            )
        if os.name == "posix" and mode & _OTHERS and not force:
            raise KeyFileError(
                f"other users can read the key file {name} (mode {mode & 0o777:04o}), expected 0600: "
                f"`chmod 600 {name}`, or --force to take it as it is",
                file=name,
            )
        return cls(bytes.fromhex(match[1].decode()))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the key to a new file of mode 0600.

        The file appears complete or not at all: the name is taken first, the content moved onto it after.

        Parameters
        ----------
        path : str or path-like
            The file to make; a key is never overwritten.

        Raises
        ------
        OutputError
            The file exists or cannot be written.
        """
        target = Path(path)
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(8)}")
        content = f"{HEADER}\n{self._secret.hex()}\n".encode()
        try:
            os.close(_create(target))
        except FileExistsError:
            raise OutputError(
                f"{target} exists already and a key is never overwritten", file=target
            ) from None
        except OSError as error:
            raise _unwritten(target, error) from None
        try:
            with os.fdopen(_create(temporary), "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(target)
        except OSError as error:
            for leftover in (temporary, target):
                with contextlib.suppress(OSError):
                    leftover.unlink(missing_ok=True)
            raise _unwritten(target, error) from None

    def subkey(self, purpose: str) -> bytes:
        """Return the 32 bytes for one purpose: HMAC-SHA256 of its name.

        The name stands where HKDF (RFC 5869) has its info and a counter: one block of pseudorandom output.

        Parameters
        ----------
        purpose : str
            What the bytes are for; the same name gives the same bytes.

        Returns
        -------
        bytes
            32 pseudorandom bytes.

        Raises
        ------
        InputError
            The name is empty.
        """
        if not purpose:
            raise InputError("a subkey needs the name of its purpose, got an empty one")
        return hmac.digest(self._secret, _DOMAIN + purpose.encode(), hashlib.sha256)

    def derived(self, label: str) -> Key:
        """Return the key of a project, a model or a customer, which can be handed out.

        HKDF-SHA256 (RFC 5869) of this key, the label in its info. Neither this key nor the keys of other labels
        follow from it.

        Parameters
        ----------
        label : str
            The same one gives the same key.

        Returns
        -------
        Key

        Raises
        ------
        InputError
            The label is empty.
        """
        if not label:
            raise InputError("a derived key needs a label, got an empty one")
        from cryptography.hazmat.primitives.hashes import SHA256
        from cryptography.hazmat.primitives.kdf.hkdf import HKDF

        info = _DERIVED + label.encode("utf-8", "surrogatepass")
        return Key(HKDF(algorithm=SHA256(), length=KEY_BYTES, salt=None, info=info).derive(self._secret))

    @property
    def fingerprint(self) -> str:
        """Return 16 hexadecimal digits that name the key in public: nothing of it follows from them.

        They are the start of a subkey with a purpose of its own, so they are neither secret nor random numbers
        of any mark.
        """
        return self.subkey(_FINGERPRINT)[:_FINGERPRINT_BYTES].hex()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Key) and hmac.compare_digest(self._secret, other._secret)

    def __hash__(self) -> int:
        return hash(self.subkey("python hash"))

    def __repr__(self) -> str:
        return "Key(secret)"

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError("a key cannot be changed")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError("a key cannot be changed")

    def __copy__(self) -> Key:
        return self

    def __deepcopy__(self, memo: object) -> Key:
        return self

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        raise TypeError("a key cannot be pickled, use save and load")


def is_key_file(path: str | os.PathLike[str]) -> bool:
    """Return whether a file begins as a key file of any version does; False where it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            return file.read(len(_ANY_HEADER)) == _ANY_HEADER
    except OSError:
        return False


def _unwritten(target: Path, error: OSError) -> OutputError:
    return OutputError(f"cannot write the key file {target}: {error.strerror or 'error'}", file=target)


def _create(path: Path) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
