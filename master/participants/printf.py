"""Log messages of FMI 2.0 with their printf arguments.

The standard's logger is variadic, which ctypes does not support. On 64-bit Linux, a callee
receives integers and pointers in one sequence, and floating-point numbers in another one. A
callback that declares enough of both therefore receives every argument of the message.
"""

import ctypes
import platform
import re
import sys

WORDS, DOUBLES = 24, 8
"""Maximum number of integers and pointers, and of floating-point numbers, in a message."""
HEARD = sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64")
CONVERSION = re.compile(
    r"%(?P<flags>[-+ #0]*)(?P<width>\*|\d+)?(?:\.(?P<precision>\*|\d*))?"
    r"(?P<length>hh|h|ll|l|z|j|t)?(?P<kind>[diouxXcspeEfFgG%])"
)
SIZES = {"hh": 1, "h": 2, None: 4}

Logger = ctypes.CFUNCTYPE(
    None,
    ctypes.c_void_p,  # environment
    ctypes.c_char_p,  # instance
    ctypes.c_int,  # status
    ctypes.c_char_p,  # category
    ctypes.c_char_p,  # message
    *([ctypes.c_uint64] * WORDS if HEARD else []),
    *([ctypes.c_double] * DOUBLES if HEARD else []),
)
"""fmi2CallbackLogger with its variadic arguments declared."""


def printed(message, arguments):
    """Return the text of a message that `Logger` received, with its arguments."""
    text = (message or b"").decode(errors="replace")
    if not arguments:
        return text.replace("%%", "%")
    words, doubles = iter(arguments[:WORDS]), iter(arguments[WORDS:])
    try:
        return CONVERSION.sub(lambda match: _converted(match, words, doubles), text)
    except StopIteration:
        return text


def _converted(match, words, doubles):
    """Return one formatted conversion, and consume its arguments."""
    kind = match["kind"]
    if kind == "%":
        return "%"
    width = _size_of(match["width"], words)
    precision = _size_of(match["precision"], words)
    sized = "" if precision is None else f".{precision}"
    form = f"%{match['flags']}{'' if width is None else width}{sized}"
    if kind in "eEfFgG":
        return f"{form}{kind}" % next(doubles)
    word = next(words)
    if kind == "s":
        raw = ctypes.string_at(word) if word else b"(null)"
        return f"{form}s" % raw.decode(errors="replace")
    if kind == "p":
        return f"{form}s" % hex(word)
    if kind == "c":
        return f"{form}s" % chr(word & 0xFF)
    bits = 8 * SIZES.get(match["length"], 8)
    number = word & ((1 << bits) - 1)
    if kind in "di" and number >> (bits - 1):
        number -= 1 << bits
    return f"{form}{kind}" % number


def _size_of(text, words):
    """Return a width or precision; `*` consumes an argument."""
    if text != "*":
        return text
    number = next(words) & 0xFFFFFFFF
    return number - (1 << 32) if number >> 31 else number
