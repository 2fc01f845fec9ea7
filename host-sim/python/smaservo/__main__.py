"""python -m smaservo inspect FILE..., a door to `host-sim inspect`: the same texts and exit codes."""

from __future__ import annotations

import argparse
import sys

from . import Error, UserError, __version__, _core


def inspect(args: argparse.Namespace) -> None:
    settings: dict[str, str] = {}
    for text in args.set:
        key, equals, value = text.partition('=')
        if not key or not equals:
            raise UserError(f'--set {text}: must be key=value')
        settings[key] = value
    mistaken = 0
    documents = []
    for i, trace in enumerate(args.trace):
        text, document, has_mistakes = _core.inspect_file(trace, args.wire, settings, args.column, args.period_s)
        mistaken += has_mistakes
        documents.append(document)
        if not args.json:
            print(('\n' if i > 0 else '') + text, end='')
    if args.json:
        # Each is a list of one, on lines of its own.
        print('[\n' + ',\n'.join(document[2:-3] for document in documents) + '\n]')
    sys.stdout.flush()
    if mistaken:
        raise UserError(
            f'{mistaken} of {len(args.trace)} files {"has" if mistaken == 1 else "have"} mistakes, named above'
        )


def main() -> int:
    parser = argparse.ArgumentParser(prog='python -m smaservo')
    parser.add_argument('--version', action='version', version=__version__)
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    command = commands.add_parser('inspect', help='show what files of measurements hold, and their mistakes')
    command.add_argument('trace', nargs='+', metavar='TRACE', help='table as text or MCAP file')
    command.add_argument('--wire', help='preset or file that ends in .toml: judges length, load and power, too')
    command.add_argument('--set', action='append', default=[], help='key=value of the wire; repeatable')
    command.add_argument('--column', action='append', default=[], help='rename of a column; repeatable')
    command.add_argument('--period-s', type=float, help='time between rows of a trace without time, s')
    command.add_argument('--json', action='store_true', help='print the facts as JSON')
    try:
        inspect(parser.parse_args())
    except (Error, ValueError) as error:
        print(f'host-sim: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
