#!/usr/bin/python3
"""moving_picture.py LOG.csv PICTURE.svg: a wire with its weight that follows set-points, beside the curves, from the
log of `host-sim simulate --out`. The picture moves by itself in a browser, and is light or dark as the page around it.
"""

import csv
import sys

FROM_S, SECONDS = 0.56, 12  # from where the servo is enabled
FRAMES = 240  # of the wire and the cursor
POINTS = 600  # of a curve
WIDTH, HEIGHT = 880, 330
LEFT, RIGHT, TOP, BOTTOM = 330, 20, 46, 46  # around the curves
LONGEST, SHORTEST = 4.4, 0.4  # % of strain, at the lower and the upper edge

STYLE = """
svg { font: 15px system-ui, sans-serif; }
.ink { fill: #1c1f23; } .soft { fill: #5c6470; }
.axis { stroke: #c3c8cf; } .clamp { fill: #5c6470; } .weight { fill: #5c6470; }
.curve { fill: none; stroke-linejoin: round; }
.true { stroke: #9aa2ad; stroke-width: 6; } .estimate { stroke: #0b62c4; stroke-width: 2; }
.wanted { stroke: #1c1f23; stroke-width: 1.3; stroke-dasharray: 5 4; }
@media (prefers-color-scheme: dark) {
  .ink { fill: #e6e9ed; } .soft { fill: #a3abb6; }
  .axis { stroke: #454c56; } .clamp { fill: #a3abb6; } .weight { fill: #a3abb6; }
  .true { stroke: #6a7380; } .estimate { stroke: #63a8ff; } .wanted { stroke: #e6e9ed; }
}
"""


def rows(path):
    with open(path, newline='') as file:
        for row in csv.DictReader(line for line in file if not line.startswith('#')):
            time_s = float(row['time_s']) - FROM_S
            if 0 <= time_s <= SECONDS:
                yield (time_s, *(float(row[name]) for name in ('setpoint', 'strain', 'strain_ref', 'wire_temperature_K')))


def thinned(all_rows, count):
    return [all_rows[round(i * (len(all_rows) - 1) / (count - 1))] for i in range(count)]


def x_of(time_s):
    return LEFT + time_s / SECONDS * (WIDTH - LEFT - RIGHT)


def y_of(strain):
    return TOP + (100 * strain - SHORTEST) / (LONGEST - SHORTEST) * (HEIGHT - TOP - BOTTOM)


def curve(kind, points):
    path = ' '.join(f'{x_of(t):.1f},{y_of(v):.1f}' for t, v in points)
    return f'<polyline class="curve {kind}" points="{path}"/>'


def animated(attribute, values, more=''):
    return f'<animate attributeName="{attribute}" dur="{SECONDS}s" repeatCount="indefinite" values="{";".join(values)}"{more}/>'


def heat(temperature_K):
    """From blue at 25 degC to red at 110 degC."""
    share = min(1, max(0, (temperature_K - 298) / 85))
    cold, hot = (0x2f, 0x74, 0xc0), (0xd6, 0x33, 0x1c)
    return '#' + ''.join(f'{round(c + share * (h - c)):02x}' for c, h in zip(cold, hot))


def picture(log):
    frames, points = thinned(log, FRAMES), thinned(log, POINTS)
    ends = [f'{y_of(row[3]):.1f}' for row in frames]
    wire_x, first, left, bottom = 120, ends[0], x_of(0), HEIGHT - BOTTOM
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="A weight on a '
           'wire follows set-points; the strain that is estimated lies on the true one">',
           f'<style>{STYLE}</style>',
           f'<rect class="clamp" x="{wire_x - 40}" y="8" width="80" height="12" rx="2"/>',
           f'<line x1="{wire_x}" x2="{wire_x}" y1="20" y2="{first}" stroke="{heat(frames[0][4])}" stroke-width="4">',
           animated('y2', ends), animated('stroke', [heat(row[4]) for row in frames]), '</line>',
           f'<rect class="weight" x="{wire_x - 30}" y="{first}" width="60" height="34" rx="4">',
           animated('y', ends), '</rect>',
           f'<text class="soft" x="{wire_x + 48}" y="18">wire,</text>',
           f'<text class="soft" x="{wire_x + 48}" y="36">blue cold, red hot</text>']
    for strain in (1, 2, 3, 4):
        y = y_of(strain / 100)
        out += [f'<line class="axis" x1="{left}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>',
                f'<text class="soft" x="{left - 10}" y="{y + 5:.1f}" text-anchor="end">{strain} %</text>']
    for time_s in range(0, SECONDS + 1, 2):
        out.append(f'<text class="soft" x="{x_of(time_s):.1f}" y="{bottom + 22}" text-anchor="middle">{time_s} s</text>')
    x = left
    for kind, title in (('true', 'strain'), ('estimate', 'estimated from the resistance'), ('wanted', 'set-point')):
        out += [f'<line class="curve {kind}" x1="{x}" x2="{x + 28}" y1="22" y2="22"/>',
                f'<text class="ink" x="{x + 36}" y="27">{title}</text>']
        x += 62 + 8 * len(title)
    out += ['<clipPath id="past">', f'<rect x="{left - 4}" y="0" width="0" height="{HEIGHT}">',
            animated('width', ['4', f'{WIDTH - RIGHT - left + 8}']), '</rect></clipPath>', '<g clip-path="url(#past)">',
            curve('true', [(row[0], row[3]) for row in points]), curve('estimate', [(row[0], row[2]) for row in points]),
            curve('wanted', [(row[0], row[1]) for row in points]), '</g>', '</svg>']
    return '\n'.join(out) + '\n'


def main(arguments):
    log, path = arguments
    with open(path, 'w') as file:
        file.write(picture(list(rows(log))))


if __name__ == '__main__':
    main(sys.argv[1:])
