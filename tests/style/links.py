#!/usr/bin/python3
"""Reads every link in every *.md and fails on one that leads nowhere: a file or folder that is not
there, a heading that is not in it, or a name in code font, [`name`](file), that the file does not
contain (of `Suite.Test`, `name(q, v)` and `a::b` every word but the arguments must). Links to
other sites are not followed."""
import pathlib
import re
import subprocess
import sys

CODE_BLOCK = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<!\\)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)(?:\s+\"[^\"]*\")?\)")
NAME = re.compile(r"`([^`]+)`")


def headings(text):
    """As GitHub makes anchors of them."""
    for line in CODE_BLOCK.sub("", text).splitlines():
        if line.startswith("#"):
            title = re.sub(r"[^\w\- ]", "", line.lstrip("#").strip().lower())
            yield title.replace(" ", "-")


def words(name):
    return re.findall(r"\w+", re.sub(r"\(.*", "", name))


def complaints(root):
    listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard", "*.md"],
                            check=True, capture_output=True, text=True).stdout.split("\n")
    for page in filter(None, listed):
        file = pathlib.Path(root, page)
        if file.exists():
            yield from (f"{page}: {wrong}" for wrong in judge(file, file.read_text()))


def judge(page, text):
    for label, target in LINK.findall(CODE_BLOCK.sub("", text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, heading = target.partition("#")
        aim = page if not path else page.parent / path
        if not aim.exists():
            yield f"[{label}]({target}): there is no {path}"
            continue
        if heading and aim.suffix == ".md" and heading not in headings(aim.read_text()):
            yield f"[{label}]({target}): {path or page.name} has no heading '{heading}'"
        if aim.is_dir():
            continue
        content = aim.read_text(errors="replace")
        for name in NAME.findall(label):
            absent = [word for word in words(name)
                      if not re.search(rf"\b{re.escape(word)}\b", content) and word != aim.stem]
            if absent and not aim.name.startswith(name):
                yield f"[{label}]({target}): {', '.join(absent)} does not occur there"


def main():
    wrong = list(complaints(sys.argv[1] if len(sys.argv) > 1 else "."))
    print("\n".join(wrong) if wrong else "every link leads somewhere")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
