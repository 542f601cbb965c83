"""What the tests run in a child process: read a STEP file, write it moved, and say in plain values what came of it."""


def crash() -> None:
    """Write on standard output as the kernel does, then end as a null pointer would."""
    import ctypes

    print("noise that must not reach the parent", flush=True)
    ctypes.string_at(0)


def chatter(progress) -> int:
    """Say something on standard output and on the progress channel."""
    print("noise that must not reach the parent", flush=True)
    for step in ("first", "second"):
        progress(step)
    return 7


def crash_later(progress) -> None:
    progress("reading part.step")
    progress("fitting")
    crash()


def hang(progress=lambda _: None) -> None:
    import os
    import time

    progress(str(os.getpid()))
    time.sleep(60)


def hang_in_compiled_code(progress) -> None:
    """Hold Python's lock, as a call into the kernel does."""
    import ctypes
    import os

    progress(str(os.getpid()))
    ctypes.PyDLL(None).sleep(60)


def fill() -> None:
    """Take more memory than there is."""
    held = []
    while len(held) < 100:
        held.append(bytearray(10**8))


def kernel_exception() -> None:
    from OCP.Standard import Standard_OutOfRange

    raise Standard_OutOfRange("nobody caught this")


def defect() -> None:
    raise ZeroDivisionError("nobody foresaw this")


def refuse() -> None:
    from wpcal.core.errors import FormatError

    raise FormatError("is odd", path="part.step", line=3)


def give_up() -> None:
    import os

    os._exit(3)
