"""Copies the repository into a folder so that each constant of fusion/ is multiplied by what the environment says."""
import collections
import pathlib
import re
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / 'lint'))
import constants

HEADER = pathlib.Path(__file__).resolve().parent / 'tuned.hpp'
NUMBER = r'double|float|int|unsigned|size_t|ptrdiff_t|u?int\d+_t|Index'
PLAIN = re.compile(rf'(?:\w+::)*(?:{NUMBER}|Duration|Nanoseconds|Seconds|seconds|milliseconds)$')


def varied(constant):
    """Whether a constant can be multiplied: a plain number, no list."""
    return bool(constants.counts(constant) and PLAIN.match(constant.type))


def assignment(constant, number):
    """`kX = tuned(…)`; with number None as it was."""
    kind = constant.type
    cast = f'static_cast<{kind}>' if re.search(rf'(?:{NUMBER})$', kind) else kind
    value = f'{cast}({constant.value})'
    return f'{constant.name} = {value if number is None else f"::infuse::tuned<{kind}>({number}, {value})"}'


def rewrite(text_of, path, number_of):
    """The text of a file, with the constants for which number_of(constant) is a number read through tuned()."""
    lines = text_of.splitlines()
    changed = False
    for group in constants.declared(path):
        numbers = [number_of(c) if varied(c) else None for c in group]
        if all(n is None for n in numbers):
            continue
        changed = True
        begin, end = group[0].begin, group[0].end
        head = re.match(r'\s*(?:(?:static|inline)\s+)*', lines[begin])[0]
        constant = 'const ' if re.match(r'\s*(?:(?:static|inline)\s+)*constexpr\b', lines[begin]) else ''
        assigned = ', '.join(assignment(c, n) for c, n in zip(group, numbers))
        lines[begin:end + 1] = [f'{head}{constant}{group[0].type} {assigned};'] + [''] * (end - begin)
    text = '\n'.join(lines) + '\n'
    if not changed:
        return text
    include = '#include "fusion/tuned.hpp"'
    return text.replace('#pragma once', f'#pragma once\n{include}', 1) if '#pragma once' in text else f'{include}\n{text}'


class Registry:
    """Numbers of the constants, the same whatever is excluded. An id is FILE:NAME, of the second of that name FILE:NAME#2."""

    def __init__(self, excluded):
        self.excluded, self.ids, self.values, self.seen = excluded, [], [], collections.Counter()

    def number_of(self, file):
        def number(constant):
            self.seen[file, constant.shown] += 1
            count = self.seen[file, constant.shown]
            name = f'{file}:{constant.shown}' + (f'#{count}' if count > 1 else '')
            self.ids.append(name)
            self.values.append(constant.value)
            return None if name in self.excluded else len(self.ids) - 1
        return number


def soften(text, lines):
    """The text with these lines' constexpr as const: their values are made of those that are read through tuned()."""
    return '\n'.join(re.sub(r'\bstatic constexpr\b', 'static inline const', line).replace('constexpr', 'const')
                     if line in lines else line for line in text.split('\n'))


def copy(folder, excluded, softened):
    """Writes the copy and returns its Registry. Of the excluded ids the values stay; `softened` are (FILE, LINE). Files that
    are as they were are not touched, so that little is compiled again."""
    tracked = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=constants.ROOT, check=True,
                             capture_output=True, text=True).stdout.splitlines()
    registry = Registry(excluded)
    for name in sorted(tracked):
        source = constants.ROOT / name
        if not source.is_file():
            continue
        content = source.read_bytes()
        if re.match(r'fusion/.*\.[ch]pp$', name):
            text = rewrite(content.decode(), source, registry.number_of(name))
            content = soften(text, [line for file, line in softened if file == name]).encode()
        elif name == 'cmake/targets.cmake':  # a constant that is a variable is another type to some warnings
            content = content.replace(b'-Werror', b'')
        write(folder / name, content, source.stat().st_mode)
    write(folder / 'fusion/tuned.hpp', HEADER.read_bytes(), 0o644)
    return registry


def write(target, content, mode):
    if target.is_file() and target.read_bytes() == content:
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)
    target.chmod(mode & 0o777)
