#!/usr/bin/env python3
"""links.py FILE ...: lines "file:line: link" of the links that lead nowhere, and status 1 if there are any.

Part of `toolchain/dev check`. It looks at links to files and folders of the project, `[text](path)` and
`[text](path#heading)`, also of pictures. A path has to be a file that git knows or would add, or a folder of such
files, in the same letters; so what is only in build/ does not count, nor what another clone has beside it. A heading
is written as GitHub makes it: small letters, blanks as hyphens, no other signs. Blocks of code between ``` marks are
left out. Of a notebook (.ipynb) the cells of text are looked at, and the line is counted in these.
"""

from functools import cache
import json
import os
from pathlib import Path
import re
import sys

from parts import ROOT, git_files

LINK = re.compile(r'\]\(([^()\s]+)(?: "[^"]*")?\)')


@cache
def places():
    """All files of the project and the folders that they are in."""
    files = git_files()
    return {*files, *(str(folder) for file in files for folder in Path(file).parents)}


@cache
def lines_of(file):
    """The lines of a file with their numbers, without blocks of code."""
    found, fenced = [], False
    text = (ROOT / file).read_text()
    if file.endswith('.ipynb'):
        cells = [cell for cell in json.loads(text)['cells'] if cell['cell_type'] == 'markdown']
        text = '\n'.join(''.join(cell['source']) for cell in cells)
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith('```'):
            fenced = not fenced
        elif not fenced:
            found.append((number, line))
    return found


@cache
def headings(file):
    """The headings of a file as links name them; of several that are the same, the second one ends in -1."""
    found = set()
    for _, line in lines_of(file):
        heading = re.match(r'#{1,6} +(.*?)[ #]*$', line)
        if heading is None:
            continue
        text = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', heading[1])
        name = re.sub(r'[^\w\- ]', '', text.lower()).replace(' ', '-')
        count = 0
        while (f'{name}-{count}' if count else name) in found:
            count += 1
        found.add(f'{name}-{count}' if count else name)
    return found


def leads_somewhere(file, link):
    path, _, heading = link.partition('#')
    there = os.path.normpath(os.path.join(os.path.dirname(file), path)) if path else file
    if there not in places():
        return False
    return not heading or there.endswith(('.md', '.ipynb')) and heading in headings(there)


def dead_links(file):
    for number, line in lines_of(file):
        for link in LINK.findall(line):
            if not re.match(r'[a-z]+:', link) and not leads_somewhere(file, link):
                yield f'{file}:{number}: {link}'


def main():
    dead = [line for file in sys.argv[1:] for line in dead_links(file)]
    if dead:
        print('\n'.join(dead))
    return 1 if dead else 0


if __name__ == '__main__':
    sys.exit(main())
