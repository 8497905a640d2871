"""LZF decompression, the codec of compressed PCD files."""

from ..errors import InputError

MAX_RATIO = 88
"""Three bytes of input give at most 264 of output."""


def lzf_decompress(where: str, data: bytes, n_out: int) -> bytes:
    """The original bytes.

    A control byte below 32 starts a run of that many plus one literal bytes; any other refers back
    into the output. Source: the format notes of liblzf 3.6 (M. Lehmann).

    Args:
        where: file name for messages.
        data: the whole compressed block.
        n_out: length of the original, in bytes.

    Raises:
        InputError: the block does not decompress to exactly `n_out` bytes.
    """
    # A block that cannot grow to n_out is found out before any work, however large n_out claims to be.
    if n_out > MAX_RATIO * len(data):
        raise _damaged(where, f"{len(data)} bytes cannot hold {n_out}")
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += data[at]
                at += 1
            distance = ((control & 31) << 8) + data[at] + 1
            at += 1
            length += 2
            start = len(out) - distance
            if start < 0:
                raise _damaged(where, "it refers to bytes before its start")
            if distance >= length:
                out += out[start : start + length]
            else:
                # The reference overlaps what it writes: a pattern that repeats.
                out += (out[start:] * (length // distance + 1))[:length]
            if len(out) > n_out:
                raise _damaged(where, f"it holds more than {n_out} bytes")
    except IndexError as e:
        raise _damaged(where, "it ends within a reference") from e
    if len(out) != n_out:
        raise _damaged(where, f"it holds {len(out)} bytes of {n_out}")
    return bytes(out)


def _damaged(where: str, what: str) -> InputError:
    return InputError(f"{where}: the compressed data is damaged: {what}. Fix: copy or export the scan again.")
