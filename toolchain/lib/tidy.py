#!/usr/bin/env python3
"""tidy.py [--syntax] [FILE.cpp ...]: clang-tidy over every source that a target compiles, or over those named.

What was clean is kept on this machine by content, outside the clone: the command, the text of the source and of
all our headers in it, the configuration, the tool. --syntax instead lets clang++ read the sources beside what has
changed since the last commit, or in it.
"""

import concurrent.futures
import hashlib
import json
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys

from parts import KEPT, ROOT

TREE = ROOT / 'build/sanitize'
TIDY = 'clang-tidy-22'
CLEAN = KEPT / 'tidy'


def included(unit):
    """The sources that a unit puts together; of any other source only itself."""
    if '/together/' not in str(unit):
        return [unit]
    return [ROOT / name for name in re.findall(r'^#include "(.*)"$', unit.read_text(), re.M)]


def units():
    """Each source once, with its command; what two targets compile, in the first of them."""
    seen, found = set(), []
    for entry in json.loads((TREE / 'compile_commands.json').read_text()):
        unit = Path(entry['file'])
        sources = [source for source in included(unit) if source not in seen]
        inside = all(source.is_relative_to(ROOT) for source in sources)
        ours = [s for s in sources if not s.is_relative_to(ROOT / 'build')]
        if inside and ours:
            seen.update(sources)
            found.append((unit, entry['command']))
    return found


def compiler_words(command, *instead):
    """A command without ccache and without what it would write."""
    words = [word for word in shlex.split(command) if word != 'ccache' and not word.endswith('/ccache')]
    at = words.index('-o')
    del words[at:at + 2]
    words.remove('-c')
    return words[:1] + list(instead) + words[1:]


def key(unit, command):
    """One number over all that the answer depends on; the clone's folder is no part of it."""
    rule = subprocess.run(compiler_words(command, '-MM'), cwd=TREE, capture_output=True, text=True)
    if rule.returncode != 0:
        return None
    files = rule.stdout.replace('\\\n', ' ').split()[1:]
    total = hashlib.sha256(version().encode())
    total.update(command.replace(str(ROOT), '').encode())
    for name in ['.clang-tidy', 'tests/.clang-tidy', 'toolchain/lib/tidy.py', *files]:
        path = Path(os.path.normpath(ROOT / name))
        total.update(str(path).replace(str(ROOT), '').encode() + path.read_bytes())
    return total.hexdigest()[:32]


def version():
    return subprocess.run([TIDY, '--version'], capture_output=True, text=True, check=True).stdout


def without(unit):
    """Checks that a unit goes without, beside those of the .clang-tidy above it."""
    if '/together/' not in str(unit):
        return ''
    checks = ['-bugprone-suspicious-include']
    if f'{TREE}/tests/' in str(unit):
        checks += re.findall(r'^ *- (-.*)$', (ROOT / 'tests/.clang-tidy').read_text(), re.M)
    return ','.join(checks)


def tidy(unit, command):
    """What clang-tidy says of it; empty where it is clean, or was."""
    known = key(unit, command)
    if known and (CLEAN / known).exists():
        return ''
    answer = subprocess.run([TIDY, '-p', str(TREE), '--quiet', f'--checks={without(unit)}', str(unit)],
                            cwd=TREE, capture_output=True, text=True)
    if answer.returncode == 0:
        if known:
            (CLEAN / known).touch()
        return ''
    return answer.stdout + answer.stderr


def syntax(unit, command):
    answer = subprocess.run(compiler_words(command, '-fsyntax-only'), cwd=TREE, capture_output=True, text=True)
    return answer.stdout + answer.stderr if answer.returncode else ''


def git(*words):
    return subprocess.run(['git', *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


def changed_folders():
    """Folders with changes since the last commit, or in it where nothing has changed, and those of their tests."""
    changed = git('diff', '--name-only', 'HEAD') + git('ls-files', '--others', '--exclude-standard')
    names = [name for name in changed or git('diff', '--name-only', 'HEAD~1') if name.endswith(('.cpp', '.hpp'))]
    folders = {str(Path(name).parent).removeprefix('tests/') for name in names}
    return {ROOT / folder for folder in folders} | {ROOT / 'tests' / folder for folder in folders}


def main(words):
    only_syntax = '--syntax' in words
    asked = {Path(os.environ.get('here', '.'), word).resolve() for word in words if word != '--syntax'}
    subprocess.run(['cmake', '--preset', 'sanitize'], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    CLEAN.mkdir(parents=True, exist_ok=True)
    chosen = units()
    if asked:
        known = {source for unit, _ in chosen for source in included(unit)}
        for name in sorted(map(str, asked - known)):
            sys.exit(f'{name}: no target compiles it')
        chosen = [(unit, command) for unit, command in chosen if asked & set(included(unit))]
    elif only_syntax:
        folders = changed_folders()
        chosen = [(unit, command) for unit, command in chosen
                  if any(source.parent in folders for source in included(unit))]
    look, failed = (syntax if only_syntax else tidy), False
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = set()
        answers = [pool.submit(look, *unit) for unit in chosen]
        for k, answer in enumerate(concurrent.futures.as_completed(answers), 1):
            print(f'[{k}/{len(chosen)}]', flush=True)
            said = answer.result()
            failed = failed or bool(said)
            found |= set(re.findall(r'^.*(?:warning|error): .*$', said, re.M)) or ({said} if said else set())
        for line in sorted(found):
            print(line.replace(f'{ROOT}/', ''))
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
