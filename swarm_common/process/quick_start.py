"""Quick start of a process, for which its user waits, and of one that can fork: of one thread.

A fork copies only one thread of a process. A lock that another thread holds at that moment stays
locked in the copy for ever, and any thread that wants it hangs. Two libraries start a thread when
they are imported, long before anybody needs it:

- OpenBLAS (numpy): its workers; `OPENBLAS_NUM_THREADS=1` keeps it from that.
- LTTng-UST, which rclpy's wheels are linked with: two listeners that wait for a session of a
  tracer. Its manual calls a fork without liblttng-ust-fork unsafe, and it has no switch.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import os
import sys
from collections.abc import Iterator
from types import ModuleType

QUIET = {
    "OPENBLAS_NUM_THREADS": "1",
    "LTTNG_UST_REGISTER_TIMEOUT": "0",  # wait for no listener
}
IMPOSSIBLE = 1 << 60  # [bytes] of stack, more than there are addresses
ATTRIBUTES = 128  # [bytes], at least the size of pthread_attr_t
BLAS = "scipy.linalg.cython_blas"


@contextlib.contextmanager
def without_collector() -> Iterator[None]:
    """Disable garbage collection within it; objects alive at its end are never collected.

    Imports and compiled kernels make a million objects and hardly any garbage.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def load_numba() -> None:
    """Load what numba needs for its first kernel, without scipy.linalg.

    numba imports that, slowly, only to learn whether kernels may multiply matrices. Ours do not.
    """
    if BLAS in sys.modules:
        return
    hidden: dict[str, ModuleType | None] = {BLAS: None}  # importing it raises ImportError
    sys.modules.update(hidden)  # type: ignore[arg-type]
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        del sys.modules[BLAS]


@contextlib.contextmanager
def without_threads() -> Iterator[None]:
    """Within it, no library's C code can start a thread: each attempt fails with EAGAIN.

    What does this must be able to do without, and the process must end by `os._exit`, as a
    library's own end may wait for the thread that it thinks it has.
    """
    os.environ.update(QUIET)
    libc = ctypes.CDLL(None)
    usual = ctypes.create_string_buffer(ATTRIBUTES)
    huge = ctypes.create_string_buffer(ATTRIBUTES)
    has_switch = hasattr(libc, "pthread_setattr_default_np")  # glibc has
    if has_switch:
        libc.pthread_getattr_default_np(usual)
        libc.pthread_attr_init(huge)
        libc.pthread_attr_setstacksize(huge, ctypes.c_size_t(IMPOSSIBLE))
        libc.pthread_setattr_default_np(huge)
    try:
        yield
    finally:
        if has_switch:
            libc.pthread_setattr_default_np(usual)


def thread_count() -> int:
    """Return the number of threads of this process, those of libraries included."""
    return len(os.listdir("/proc/self/task"))
