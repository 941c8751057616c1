"""An adaptive range coder for small alphabets: whole numbers only, so that every machine writes the same bytes."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["Decoder", "Encoder", "Model"]

_TOP, _BITS = 1 << 32, 24
_BOTTOM = 1 << _BITS
# Counts are halved beyond this sum; a symbol seen counts this much.
_MOST, _STEP = 1 << 14, 24


class Model:
    """How often each of some symbols came; learns as it is used, the same way on both sides."""

    def __init__(self, first: Sequence[int]) -> None:
        """Start with these counts, all above 0."""
        self.counts = list(first)
        self.total = sum(self.counts)

    def learn(self, symbol: int) -> None:
        """Count a symbol."""
        self.counts[symbol] += _STEP
        self.total += _STEP
        if self.total > _MOST:
            self.counts = [(count + 1) >> 1 for count in self.counts]
            self.total = sum(self.counts)


class Encoder:
    """Writes symbols; `finish` returns the bytes (carries run back, after Schindler's range coder)."""

    def __init__(self) -> None:
        self._low, self._range, self._out = 0, _TOP - 1, bytearray()

    def symbol(self, model: Model, symbol: int) -> None:
        """Write a symbol and let the model learn it."""
        self._take(sum(model.counts[:symbol]), model.counts[symbol], model.total)
        model.learn(symbol)

    def bits(self, value: int, count: int) -> None:
        """Write up to 20 bits as they are."""
        self._take(value, 1, 1 << count)

    def _take(self, start: int, width: int, total: int) -> None:
        unit = self._range // total
        self._low += start * unit
        self._range = unit * width
        if self._low >= _TOP:
            self._low -= _TOP
            self._carry()
        while self._range < _BOTTOM:
            self._out.append(self._low >> _BITS)
            self._low = (self._low << 8) & (_TOP - 1)
            self._range <<= 8

    def _carry(self) -> None:
        place = len(self._out) - 1
        while self._out[place] == 255:
            self._out[place] = 0
            place -= 1
        self._out[place] += 1

    def finish(self) -> bytes:
        """Return the bytes, without zeros at their end: a decoder reads zeros beyond the end."""
        for keep in range(1, 5):  # as few bytes as name a value within the range
            unit = 1 << (32 - 8 * keep)
            rounded = (self._low + unit - 1) // unit * unit
            if rounded < self._low + self._range:
                break
        value = rounded
        if value >= _TOP:
            value -= _TOP
            self._carry()
        return bytes(self._out + value.to_bytes(4, "big")).rstrip(b"\0")


class Decoder:
    """Reads what `Encoder` wrote, with models that start and learn alike."""

    def __init__(self, content: bytes) -> None:
        self._content, self._place = content, 4
        self._range = _TOP - 1
        self._code = int.from_bytes(content[:4].ljust(4, b"\0"), "big")

    @property
    def exhausted(self) -> bool:
        """Whether more was read than there was: the content is damaged."""
        return self._place > len(self._content) + 8

    def symbol(self, model: Model) -> int:
        """Read a symbol and let the model learn it."""
        unit = self._range // model.total
        value = min(self._code // unit, model.total - 1)
        start = symbol = 0
        while start + model.counts[symbol] <= value:
            start += model.counts[symbol]
            symbol += 1
        self._took(start, model.counts[symbol], unit)
        model.learn(symbol)
        return symbol

    def bits(self, count: int) -> int:
        """Read up to 20 bits."""
        unit = self._range >> count
        value = min(self._code // unit, (1 << count) - 1)
        self._took(value, 1, unit)
        return value

    def _took(self, start: int, width: int, unit: int) -> None:
        self._code -= start * unit
        self._range = unit * width
        while self._range < _BOTTOM:
            byte = self._content[self._place] if self._place < len(self._content) else 0
            self._place += 1
            self._code = (self._code << 8) | byte
            self._range <<= 8
