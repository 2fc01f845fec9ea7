#!/usr/bin/env python3
"""api.py [--write FILE | --compare FILE] SOURCES: the public declarations of the library's public headers.

What is read are the headers of headers.txt, as C++ tokens, so that neither formatting nor comments nor the bodies of
functions make a difference. Left out are private and protected members, the namespaces `detail`, definitions of
what was declared before, and values of constants and of members; that a member has a default is said.
"""

import argparse
import difflib
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
COMMAND = 'toolchain/library/api.py --write tests/golden/api.txt .'

TOKEN = re.compile(r'''
    //[^\n]* | /\*.*?\*/ | ^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*     # comments, lines of the preprocessor
  | R"(?P<mark>[^(\s]*)\(.*?\)(?P=mark)" | "(?:\\.|[^"\\])*" | (?<![0-9A-Fa-f])'(?:\\.|[^'\\])+'
  | [A-Za-z_]\w* | \.?\d(?:[eEpP][+-]|'?[\w.])*
  | ::|->\*?|<=>|&&|\|\||\+\+|--|\.\.\.|[<>=!+*/%&|^-]=|<<|[^\s]
''', re.VERBOSE | re.DOTALL | re.MULTILINE)
OPENS, CLOSES = '([{', ')]}'


def tokens_of(text):
    found = (match.group() for match in TOKEN.finditer(text))
    return [token for token in found if not token.startswith(('//', '/*')) and not token.lstrip().startswith('#')]


def listed_headers():
    lines = (HERE / 'headers.txt').read_text().splitlines()
    return [line.split()[1] for line in lines if line and not line.startswith('#')]


def end_of_group(tokens, at):
    """The place behind the bracket that closes the one at `at`."""
    depth = 0
    for place in range(at, len(tokens)):
        depth += (tokens[place] in OPENS) - (tokens[place] in CLOSES)
        if depth == 0:
            return place + 1
    raise ValueError('a bracket is not closed')


def end_of_angle(tokens, at):
    depth = 0
    while at < len(tokens):
        if tokens[at] in OPENS:
            at = end_of_group(tokens, at)
            continue
        depth += (tokens[at] == '<') - (tokens[at] == '>')
        at += 1
        if depth == 0:
            return at
    raise ValueError('a template is not closed')


def words_of(tokens):
    """The tokens of a declaration that are neither attributes nor in brackets or in the lists of templates: what it
    declares, with their places."""
    at, words = 0, []
    while at < len(tokens):
        if tokens[at:at + 2] == ['[', '[']:
            at = end_of_group(tokens, at)
        elif tokens[at] == '<' and words and words[-1][0] != 'operator':
            at = end_of_angle(tokens, at)
        elif tokens[at] in OPENS:
            words.append((tokens[at], at))
            at = end_of_group(tokens, at)
        else:
            words.append((tokens[at], at))
            at += 1
    return words


NO_BLANK_BEFORE = {',', ';', ')', ']', '>', '::', '(', '[', '<', '...', '.'}
NO_BLANK_BEHIND = {'(', '[', '<', '::', '~', '!', '.', 'operator'}
BLANK_AROUND = {'=', '->', '||', 'requires', 'template', 'return'}


def line_of(tokens):
    text, depth = '', 0
    for place, token in enumerate(tokens):
        depth += (token == '(') - (token == ')')
        conjunction = 'concept' in tokens or 'requires' in tokens and depth == 0
        before = tokens[place - 1] if place else ''
        if not place or 'operator' in tokens[max(0, place - 2):place]:
            blank = False
        elif '&&' in (before, token):
            blank = conjunction or before == '&&' and token not in NO_BLANK_BEFORE
        elif token in '&*':
            blank = before in (',', '=')
        elif {before, token} == {'{', '}'}:
            blank = False
        elif before in BLANK_AROUND or before == ',' or token == '<' and before == 'template':
            blank = True
        else:
            blank = token not in NO_BLANK_BEFORE and before not in NO_BLANK_BEHIND
        text += (' ' if blank else '') + token
    return text


def without_values(tokens):
    """A declaration of constants or members, whose values are replaced by dots."""
    kept, value = [], False
    words = words_of(tokens)
    ends = [place for _, place in words[1:]] + [len(tokens)]
    for (word, place), end in zip(words, ends):
        if word == ',':
            value = False
        elif not value and word in ('=', '{'):
            kept, value = kept + ['=', '...'], True
            continue
        if not value:
            kept += tokens[place:end]
    return kept


class Reader:
    def __init__(self, tokens):
        self.tokens, self.at, self.lines = tokens, 0, []

    def say(self, depth, tokens):
        self.lines.append('  ' * depth + line_of(tokens))

    def declaration(self):
        """The tokens up to the end of a declaration or to its first brace outside of parentheses."""
        start = self.at
        while self.tokens[self.at] not in (';', '{', '}'):
            self.at = end_of_group(self.tokens, self.at) if self.tokens[self.at] in '([' else self.at + 1
        return self.tokens[start:self.at]

    def body(self):
        self.at = end_of_group(self.tokens, self.at)

    def rest(self):
        """To the semicolon."""
        start = self.at
        while self.tokens[self.at] != ';':
            self.at = end_of_group(self.tokens, self.at) if self.tokens[self.at] in OPENS else self.at + 1
        self.at += 1
        return self.tokens[start:self.at - 1]

    def scope(self, depth, public, shown=True):
        while self.at < len(self.tokens) and self.tokens[self.at] != '}':
            if self.tokens[self.at] == ';':
                self.at += 1
                continue
            if self.tokens[self.at] in ('public', 'private', 'protected') and self.tokens[self.at + 1] == ':':
                public = self.tokens[self.at] == 'public'
                self.at += 2
                continue
            self.one(depth, public, shown)

    def one(self, depth, public, shown):
        tokens = self.declaration()
        words = [word for word, _ in words_of(tokens)]
        places = [place for _, place in words_of(tokens)]
        shown_here = public and shown
        opened = self.tokens[self.at] == '{'
        if words[0] == 'template':
            words, places = words[1:], places[1:]
        if words[0] == 'namespace' and opened:
            inner = shown and bool(words[1:]) and 'detail' not in words
            if inner:
                self.say(depth, tokens)
            self.at += 1
            self.scope(depth + 1, True, inner)
            self.at += 1
        elif words[0] == 'static_assert':
            self.rest()
        elif 'concept' in words:
            tokens = tokens + self.rest()
            if shown_here:
                self.say(depth, tokens)
        elif words[0] == 'enum':
            if opened:
                start = self.at
                self.body()
                tokens = tokens + [token for token, behind in zip(self.tokens[start:self.at], self.tokens[start + 1:])
                                   if (token, behind) != (',', '}')]
            self.rest()
            if shown_here:
                self.say(depth, tokens)
        elif words[0] in ('class', 'struct', 'union') and '(' not in words and '=' not in words:
            if shown_here:
                self.say(depth, tokens)
            if opened:
                self.at += 1
                self.scope(depth + 1, words[0] != 'class', shown_here)
                self.at += 1
            self.rest()
        elif '=' in words and 'operator' not in words[:words.index('=')] and words[0] != 'using' and (
                '(' not in words or words.index('=') < words.index('(')):
            # Constants, or members with a default.
            tokens = tokens + self.rest()
            if shown_here:
                self.say(depth, without_values(tokens))
        elif '(' in words:
            self.function(depth, tokens, words, places, shown_here)
        else:
            tokens = tokens + self.rest()
            if shown_here:
                self.say(depth, without_values(tokens) if opened else tokens)

    def function(self, depth, tokens, words, places, shown):
        first = words.index('(')
        if words[first - 1] == 'requires':
            first = words.index('(', first + 1)
        if words[first - 1] == 'operator':  # operator()
            first += 1
        declared_before = '::' in words[max(0, first - 2):first]
        end = end_of_group(tokens, places[first])
        if ':' in tokens[end:]:  # what a constructor initialises
            tokens = tokens[:end + tokens[end:].index(':')]
            while self.tokens[self.at] == '{' and self.tokens[self.at - 1] not in ')}':
                self.body()
                self.declaration()
        if self.tokens[self.at] == '{':
            self.body()
        else:
            self.rest()
        if shown and not declared_before:
            self.say(depth, tokens)


def api_of(text):
    reader = Reader(tokens_of(text))
    reader.scope(0, True)
    if reader.at != len(reader.tokens):
        raise ValueError(f'not understood from "{line_of(reader.tokens[reader.at:reader.at + 8])}" on')
    return reader.lines


def without_empty(lines):
    """Namespaces in which nothing is left are not named."""
    kept = []
    for line, behind in zip(lines, lines[1:] + ['']):
        deeper = len(behind) - len(behind.lstrip()) > len(line) - len(line.lstrip())
        if deeper or not line.lstrip().startswith('namespace '):
            kept.append(line)
    return kept


def api(sources):
    lines = ['The public declarations of the library. Written by: ' + COMMAND]
    for header in listed_headers():
        try:
            lines += ['', f'smaservo/{header}', *without_empty(api_of((sources / header).read_text()))]
        except (ValueError, IndexError) as error:
            sys.exit(f'api.py: {header}: {error}')
    return '\n'.join(lines) + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--write', type=Path)
    parser.add_argument('--compare', type=Path)
    parser.add_argument('sources', type=Path)
    arguments = parser.parse_args()
    text = api(arguments.sources)
    if arguments.write:
        arguments.write.write_text(text)
    elif arguments.compare:
        kept = arguments.compare.read_text()
        sys.stdout.writelines(difflib.unified_diff(
            kept.splitlines(True), text.splitlines(True), str(arguments.compare), 'the headers'))
        if kept != text:
            sys.exit(f'The API has changed. If that is wanted, write it anew, review the difference, and say it in '
                     f'CHANGELOG.md:\n  {COMMAND}')
    else:
        sys.stdout.write(text)


if __name__ == '__main__':
    main()
