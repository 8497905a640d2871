"""Names of files as text that every output can hold."""


def printable_name(name: str) -> str:
    """The name with bytes that are no UTF-8 replaced by U+FFFD.

    Python hands such bytes over as lone surrogates, which no UTF-8 file can hold; a file name may have them
    all the same.
    """
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
