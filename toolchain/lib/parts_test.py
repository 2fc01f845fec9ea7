#!/usr/bin/env python3
"""Whether a part's key changes with each file that its builds have read, as the compilers and CMake have said, and with
the versions of tools: for the trees that have been built, the release's at least. Of the others the part itself
compares the lists, after its builds. Run by ctest."""

import sys

import parts


def keys(part, names):
    """The key with the content of each of these files changed, one at a time."""
    known = parts.digest
    for name in names:
        parts.digest = lambda asked, changed=name: b'another' if asked == changed else known(asked)
        yield name, parts.key(part)
    parts.digest = known


def main():
    failures, looked = [], 0
    for name, part in parts.PARTS.items():
        usual = parts.key(part)
        if parts.key(part) != usual:
            failures.append(f'{name}: two keys of the same files differ')
        for tree, targets in part.built.items():
            if not (parts.ROOT / 'build' / tree / 'build.ninja').is_file():
                continue
            # Where a tool is missing that only this part installs, the tree has no such target yet.
            there = {line.split(':')[0] for line in parts.ninja(tree, '-t', 'targets', 'all')}
            read = parts.files_read(tree, [target for target in targets if target in there])
            looked += len(read)
            failures += [f'{name}: its key does not change with {file}'
                         for file, changed in keys(part, sorted(read)) if changed == usual]
        tools = parts.tools
        parts.tools = lambda: tools() + '\ng++ another version'
        if part.inputs and parts.key(part) == usual:
            failures.append(f'{name}: its key does not change with a tool')
        parts.tools = tools
    if looked == 0:
        failures.append('nothing was built yet')
    print('\n'.join(failures) or f'{looked} files of builds are in the keys')
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
