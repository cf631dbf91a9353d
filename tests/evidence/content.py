"""What a claim depends on: the content of folders without comments and documents."""
import hashlib
import re
import subprocess

# A raw string, a string, a character (not the separator of digits), or a comment.
TOKEN = re.compile(r'R"([^()\\ ]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\''
                   r'|//[^\n]*|/\*.*?\*/', re.DOTALL)
CODE = ('.cpp', '.hpp', '.inc', '.c', '.h')


def without_comments(text):
    """C++ code without comments, each run of white space as one space."""
    kept = TOKEN.sub(lambda m: ' ' if m.group().startswith(('//', '/*')) else m.group(), text)
    return ' '.join(kept.split())


def digest(root, folder):
    """Twelve hexadecimal digits of what is in a folder as it lies there; of tracked files only, without documents."""
    names = subprocess.run(['git', 'ls-files', '-z', '--', folder], cwd=root, check=True, capture_output=True).stdout
    total = hashlib.sha256()
    found = False
    for name in sorted(filter(None, names.decode().split('\0'))):
        path = root / name
        if name.endswith('.md') or not path.is_file():
            continue
        data = path.read_bytes()
        if name.endswith(CODE):
            data = without_comments(data.decode()).encode()
        total.update(f'{name}\0{len(data)}\0'.encode() + data)
        found = True
    return total.hexdigest()[:12] if found else None
