#!/usr/bin/env python3
"""Whether a picture counts as old where what it shows has changed, and only there; made-up files. Run by ctest."""

import hashlib
import sys

import figures
import old_figures

FIGURE = figures.Figure('picture', 'a test', ['p.png'], 'true', 1, drawn_by=['a.ts', 'b.css'], curves='c.csv')
LINES = [f'line {number}' for number in range(60)]
TIMES = range(20)


def curves(strain=0.04, deviation=0.0004, times=TIMES):
    """A strain that falls from 4 to 0.2 %."""
    rows = [f'{t},{strain * (1 - t / 20):.6f},{deviation},{0.04 * (1 - t / 20):.6f}' for t in times]
    return '\n'.join(['time_s,strain,strain_sd,strain_ref', *rows])


def usual():
    return {'p.png': 'picture', 'a.ts': '\n'.join(LINES), 'b.css': '\n'.join(LINES[:40]), 'c.csv': curves()}


def name(content):
    return hashlib.sha1(content.encode()).hexdigest()


def reasons(now, forgotten=''):
    """Why the picture of the usual files is old beside these; git has forgotten one file's content."""
    before = usual()
    old_figures.text_of = now.get
    old_figures.hash_of = lambda file: name(now[file])
    old_figures.content_of = {name(text): text for file, text in before.items() if file != forgotten}.get
    return list(old_figures.old_picture('test', FIGURE, {file: name(text) for file, text in before.items()}))


def changed(count):
    return '\n'.join([*(f'another {number}' for number in range(count)), *LINES[count:]])


CASES = [
    ('nothing', {}, None),
    ('a comment and empty lines', {'a.ts': '// why\n\n' + '\n\n'.join(LINES)}, None),
    ('other indents', {'a.ts': '\n'.join(f'  {line}' for line in LINES)}, None),
    ('three lines of a hundred', {'a.ts': changed(3)}, None),
    ('four lines of a hundred', {'a.ts': changed(4)}, 'older than a.ts: 4 of the 100 lines'),
    ('one line of forty of the style', {'b.css': '\n'.join(LINES[1:40])}, None),
    ('two lines of forty of the style', {'b.css': '\n'.join(LINES[2:40])}, 'older than b.css: 2 of the 38 lines of'),
    ('three lines, and one of the style', {'a.ts': changed(3), 'b.css': '\n'.join(LINES[1:40])}, 'older than a.ts'),
    ('a curve by half a percent of the height', {'c.csv': curves(strain=0.0402)}, None),
    ('a curve by two percent', {'c.csv': curves(strain=0.0408)}, 'older than c.csv: a curve has moved by 2.'),
    ('a band of half the width', {'c.csv': curves(deviation=0.0002)}, 'older than c.csv: a curve has moved by 1.'),
    ('another length', {'c.csv': curves(times=range(19))}, 'older than c.csv'),
    ('the picture', {'p.png': 'by hand'}, 'is not what'),
]


def main():
    failures = []
    for what, files, wanted in CASES:
        found = reasons({**usual(), **files})
        if (wanted is None) != (found == []) or wanted and wanted not in found[0]:
            failures.append(f'{what} has changed: {found or "not old"}')
    for file, now in (('a.ts', changed(60)), ('c.csv', curves(strain=0.0408))):
        if reasons({**usual(), file: now}, forgotten=file):
            failures.append(f'{file}: old, although git does not know what it was made from')
    text = 'head\n<!-- x: y -->\n\nold\n\n<!-- end of x -->\nbehind\n'
    if figures.between(text, 'x', 'f') != ('head\n<!-- x: y -->\n\n', 'old\n', '\n<!-- end of x -->\nbehind\n'):
        failures.append('the table between two marks')
    try:
        figures.between(text, 'z', 'f')
        failures.append('marks that are not there')
    except LookupError:
        pass
    print('\n'.join(failures) or f'{len(CASES) + 4} cases')
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
