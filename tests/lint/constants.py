"""Reads the numeric constants of fusion/ from its sources: those named kX whose value has a number in it, and numbers of
structs named …Options; 0, which means "none", and seeds are not counted."""
import pathlib
import re
import subprocess
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
NUMERIC = r'(?:double|float|int|unsigned|long|char|auto|bool|size_t|ptrdiff_t|u?int\d+_t|Index|Duration|Nanoseconds|Seconds|seconds|milliseconds|Float4|array<[^;=]*?>)'
CONSTANT = re.compile(rf'^\s*(?:(?:static|inline)\s+)*constexpr\s+((?:\w+::)*{NUMERIC})\s+(k[A-Z].*)$')
MEMBER = re.compile(rf'^\s+((?:\w+::)*{NUMERIC})\s+([a-z]\w*\s*(?:=|\{{)\s*.*)$')
STRUCT = re.compile(r'^\s*struct (\w*Options) (?:final )?(?::[^{]*)?\{')
LITERAL = re.compile(r'(?<![\w.])(?:0x[\da-f.]+(?:p-?\d+)?|\d[\d\']*(?:\.\d*)?(?:e[-+]?\d+)?)[fFuUlL]*\b', re.IGNORECASE)


class Constant(NamedTuple):
    """`name` is the identifier, `shown` has the struct before it; `comment` stands at the value, `context` is all that is
    said of it; `begin` and `end` are the lines of its statement, from 0."""
    name: str
    shown: str
    value: str
    comment: str
    context: str
    type: str
    begin: int
    end: int


def comment_of(line):
    """Code and comment of a line."""
    match = re.match(r'((?:[^"/]|"(?:\\.|[^"\\])*"|/(?!/))*)//[/!]?<?\s?(.*)$', line)
    return (match[1], match[2].strip()) if match else (line, '')


def declarators(text):
    """NAME, VALUE of "kA = 1, kB{2};"."""
    depth, part, parts = 0, '', []
    for c in text.split(';')[0]:
        depth += (c in '({[') - (c in ')}]')
        if c == ',' and depth == 0:
            parts.append(part)
            part = ''
        else:
            part += c
    for part in (*parts, part):
        match = re.match(r'\s*(\w+)\s*(?:=\s*|(?=\{))(.+?)\s*$', part, re.DOTALL)
        if match:
            value = match[2]
            yield match[1], ' '.join(value[1:-1].split() if value[0] == '{' and value[-1] == '}' else value.split())


def declared(path):
    """The constants of a file, statement by statement."""
    lines = path.read_text().splitlines()
    above, first, struct, of_struct, depth, i = '', True, '', '', 0, 0
    while i < len(lines):
        code, comment = comment_of(lines[i])
        opening = STRUCT.match(code)
        if opening:
            struct, depth = opening[1], 0
            of_struct = ' '.join(re.findall(r'\([Dd]ecision \d+\)', above))  # of all its members
        if struct:
            depth += code.count('{') - code.count('}')
            if depth <= 0 and not opening:
                struct = ''
        match = CONSTANT.match(code) or (MEMBER.match(code) if struct and not opening else None)
        if not code.strip():
            if comment and i and comment_of(lines[i - 1])[0].strip():
                above = ''
            above, first = f'{above} {comment}'.strip() if comment else '', True
        elif match:
            begin, text, behind = i, match[2], comment
            while ';' not in text and i + 1 < len(lines):
                i += 1
                more, comment = comment_of(lines[i])
                text, behind = f'{text} {more.strip()}', f'{behind} {comment}'.strip()
            while i + 1 < len(lines) and re.match(r'\s{12,}//', lines[i + 1]):  # the comment behind goes on
                i += 1
                behind += ' ' + comment_of(lines[i])[1]
            said = f'{above} {behind}' if first or not behind else behind
            first = False
            yield [Constant(name, f'{struct}::{name}' if struct and not re.match('k[A-Z]', name) else name, value,
                            behind or above, f'{said} {of_struct if struct else ""}', match[1], begin, i)
                   for name, value in declarators(text)]
        elif not re.match(r'\s*template\b', code):
            above = ''
        i += 1


def counts(constant):
    """Whether a constant is one that has to be justified."""
    value = constant.value
    return bool(re.search('[1-9]', value) and LITERAL.search(value) and not constant.name.endswith('seed'))


def files():
    names = subprocess.run(['git', 'ls-files', 'fusion/*.hpp', 'fusion/*.cpp'], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split()
    return [name for name in sorted(names) if (ROOT / name).is_file()]


def all_constants():
    """FILE, CONSTANT of all that counts."""
    for file in files():
        for statement in declared(ROOT / file):
            yield from ((file, constant) for constant in statement if counts(constant))
