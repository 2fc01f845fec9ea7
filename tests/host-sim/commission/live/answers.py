#!/usr/bin/env python3
"""answers.py PROGRAM ARGUMENT...: runs it on a terminal of 80 columns and answers its questions as a person does."""

import os
import pty
import re
import sys

# The cold reading, a slip of the finger, the hot reading.
ANSWERS = [b'1.5\n', b'5.o\n', b'5.0\n']
QUESTION = b'displacement in mm (Enter: no reading): '

process, terminal = pty.fork()
if process == 0:
    os.execv(sys.argv[1], sys.argv[1:])
seen = b''
answered = 0
while True:
    try:
        part = os.read(terminal, 4096)
    except OSError:  # the other end is closed
        break
    if not part:
        break
    seen += part
    while seen.count(QUESTION) > answered:
        os.write(terminal, ANSWERS[answered])
        answered += 1
sys.stdout.write(seen.replace(b'\r\x1b[K', b'\n').decode(errors='replace'))
sys.stdout.flush()
assert answered == len(ANSWERS), answered
assert b"'5.o' is no length in mm" in seen
# Lines that are drawn in one place fit the terminal, or the next would not replace them.
drawn = re.findall(rb'\r\x1b\[K([^\r\n]*)', seen)
assert len(drawn) > 10 and max(map(len, drawn)) < 80, max(drawn, key=len)
status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
sys.exit(status)
