"""The other tests of this folder find accesses beyond memory: they run in a build with the address sanitizer."""

import sys
from pathlib import Path

import smaservo
from places import run_program

WRITES_BEYOND = """
import ctypes
import smaservo
block = ctypes.create_string_buffer(100)
ctypes.memmove(ctypes.addressof(block) + LENGTH - 50, bytes(50), 50)
print('written')
"""


def test_an_access_beyond_memory_ends_the_interpreter():
    good = run_program(sys.executable, '-c', WRITES_BEYOND.replace('LENGTH', '100'))
    assert (good.returncode, good.stdout) == (0, 'written\n'), good.stderr
    bad = run_program(sys.executable, '-c', WRITES_BEYOND.replace('LENGTH', '101'))
    assert bad.returncode != 0 and 'AddressSanitizer: heap-buffer-overflow' in bad.stderr


def test_the_package_is_instrumented():
    extension = Path(sys.modules['smaservo._core'].__file__).read_bytes()
    assert smaservo.__version__ and b'__asan_report_load8' in extension and b'__ubsan_handle' in extension
