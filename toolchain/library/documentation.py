#!/usr/bin/env python3
"""documentation.py OUTPUT: HTML pages of the library's public headers, by doxygen, in OUTPUT/html.

Fails where doxygen warns: of a comment that it does not understand, of a parameter that is none, and of a class,
function, concept or enumeration without a comment. Data members, enumerators, aliases, operators and moves may say
all by their names: a unit is part of a name here.
"""

import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BY_NAME = re.compile(r'\((variable|enumvalue|typedef|friend)\) of |Member (\w+)\(\2 ?&&\)|Member operator')


def listed():
    """Target, header, purpose of each public header."""
    lines = (HERE / 'headers.txt').read_text().splitlines()
    return [line.split(None, 2) for line in lines if line and not line.startswith('#')]


def main_page(headers):
    rows = ''.join(f'| {target} | \\ref smaservo/{header} | {what} |\n' for target, header, what in headers)
    return f'''\\mainpage The library of smaservo

The public headers. What else is installed is detail.

| target smaservo:: | header | what it is for |
|---|---|---|
{rows}'''


def doxygen(output, headers):
    output.mkdir(parents=True, exist_ok=True)
    page = output / 'main.md'
    page.write_text(main_page(headers))
    installed = output / 'smaservo'  # by the names that programs include
    installed.unlink(missing_ok=True)
    installed.symlink_to(ROOT)
    inputs = ' '.join(f'"{installed / header}"' for _, header, _ in headers)
    settings = (HERE / 'Doxyfile').read_text() + (
        f'INPUT = "{page}" {inputs}\nOUTPUT_DIRECTORY = "{output}"\nSTRIP_FROM_PATH = "{output}"\n'
        f'STRIP_FROM_INC_PATH = "{output}"\n')
    done = subprocess.run(['doxygen', '-'], input=settings, text=True, capture_output=True)
    if done.returncode:
        sys.exit(f'doxygen: {done.stderr}')
    return done.stderr


def faults(warnings, output):
    found = []
    for line in warnings.splitlines():
        line = line.replace(f'{output}/smaservo/', '')
        undocumented = line.endswith('is not documented.')
        if line.strip() and not (undocumented and BY_NAME.search(line)):
            found.append(line)
    return found


def main():
    headers = listed()
    output = Path(sys.argv[1]).resolve()
    found = faults(doxygen(output, headers), output)
    if found:
        sys.exit('\n'.join(found))


if __name__ == '__main__':
    main()
