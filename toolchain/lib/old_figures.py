#!/usr/bin/env python3
"""Part of `toolchain/dev check`: which pictures are older than what they show, and where a table's marks are missing.

toolchain/figures.made has, for each picture, git's hash of the picture, of the files that draw what it shows and of the
numbers of its curves, as they were when it was made; git still has these contents. A picture is old

- where more than SLACK of the lines of the files that draw it have changed, comments and empty lines aside, or of
  those of the style sheets among them, in which fewer lines are seen. Such files change often, most of the time without
  a difference that a person sees; what has added up to this, one sees.
- where a curve or the edge of a band has moved by more than MOVED of the height of the plot.

Times of `bench` need a machine that does nothing else; so a row that its table lacks is only said.
"""

import csv
import difflib
import re
import subprocess
import sys

import bench
from figures import FIGURES, MADE, between, hash_of, recorded, text_of
from parts import ROOT, git_files

BENCH = 'tests/bench/README.md'  # has the table of `bench`
SLACK = 0.03
MOVED = 0.01


def content_of(blob):
    """What git has under this hash, or None."""
    found = subprocess.run(['git', 'cat-file', 'blob', blob], cwd=ROOT, capture_output=True, text=True)
    return found.stdout if found.returncode == 0 else None


def telling(text):
    """The lines that are neither empty nor only a comment, without indents."""
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not re.match(r'//|/\*|\*', line)]


def changed_lines(before, now):
    before, now = telling(before), telling(now)
    match = difflib.SequenceMatcher(None, before, now, autojunk=False)
    return max(len(before), len(now)) - sum(block.size for block in match.get_matching_blocks())


def curves_of(text):
    """By time: estimate, edges of its band, reference."""
    rows = {}
    for row in csv.DictReader(text.splitlines()):
        strain, band = float(row['strain']), 2 * float(row['strain_sd'])
        rows[row['time_s']] = [strain, strain - band, strain + band, float(row['strain_ref'])]
    return rows


def moved(before, now):
    """The farthest way of a curve, as a share of the height of the plot."""
    before, now = curves_of(before), curves_of(now)
    if before.keys() != now.keys():
        return 1
    values = [value for row in before.values() for value in row]
    ways = [abs(a - b) for at in before for a, b in zip(before[at], now[at])]
    return max(ways) / (max(values) - min(values))


def old_picture(name, figure, then):
    """A line for each reason why it is old."""
    picture = figure.files[0]
    again = f': toolchain/dev figures {name}'
    files = [*figure.drawn_by, *([figure.curves] if figure.curves else [])]
    if then.keys() != {picture, *files} or then[picture] != hash_of(picture):
        yield f'{picture} is not what {MADE} says{again}'
        return
    before = {file: content_of(then[file]) for file in files if then[file] != hash_of(file)}
    forgotten = [file for file, text in before.items() if text is None]
    if forgotten:
        print(f'{picture}: git does not have the {forgotten[0]} that it was made from, so its age is not known')
        return
    changed = {file: changed_lines(text, text_of(file)) for file, text in before.items() if file in figure.drawn_by}
    for kind, end in (('of its style', '.css'), ('that draw it', '')):
        lines = sum(len(telling(text_of(file))) for file in figure.drawn_by if file.endswith(end))
        among = {file: count for file, count in changed.items() if file.endswith(end)}
        if sum(among.values()) > SLACK * lines:
            yield (f'{picture} is older than {max(among, key=among.get)}: {sum(among.values())} of the {lines} lines '
                   f'{kind} have changed{again}')
            break
    if figure.curves in before:
        way = moved(before[figure.curves], text_of(figure.curves))
        if way > MOVED:
            yield (f'{picture} is older than {figure.curves}: a curve has moved by {100 * way:.1f} % of the '
                   f'height{again}')


def without_figure():
    """Pictures in Markdown files that no command makes; an SVG is drawn by hand, and is its own source."""
    known = {file for figure in FIGURES.values() for file in figure.files}
    for picture in git_files('*.png', '*.jpg', '*.jpeg', '*.gif', '*.webp'):
        if picture not in known:
            yield f'{picture}: no figure of toolchain/lib/figures.py makes it'


def missing_files():
    for name, figure in FIGURES.items():
        files = [*figure.files, *figure.drawn_by, *([figure.curves] if figure.curves else [])]
        for file in files:
            if not (ROOT / file).is_file():
                yield f'toolchain/lib/figures.py: {name}: there is no {file}'


def table_faults():
    for figure in FIGURES.values():
        for file, (marks, _) in figure.tables.items():
            try:
                between(text_of(file), marks, file)
            except LookupError as error:
                yield str(error)


def missing_rows():
    """Rows of `bench` that its README lacks."""
    shown = between(text_of(BENCH), 'bench', BENCH)[1]
    return [title for title, _ in bench.STEPS.values() if f'\n| {title} |' not in shown]


def faults():
    found = list(missing_files())
    if found:
        return found
    found = [*without_figure(), *table_faults()]
    made = recorded()
    for name, figure in FIGURES.items():
        if figure.kind == 'picture':
            found += old_picture(name, figure, made.get(name, {}))
    return found


def main():
    found = faults()
    if found:
        print('\n'.join(found))
        return 1
    rows = missing_rows()
    if rows:
        print(f'not wrong, but not whole: {BENCH} lacks {len(rows)} rows of `bench`, the first is "{rows[0]}"; on a '
              'machine that does nothing else: toolchain/dev figures bench')
    return 0


if __name__ == '__main__':
    sys.exit(main())
