#!/usr/bin/python3
"""Proves that links.py finds what it is there to find."""
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import links  # noqa: E402


def main():
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder, "page.md")
        pathlib.Path(folder, "code.hpp").write_text("double bias(int q);\nTEST(Suite, Holds) {}\n")
        pathlib.Path(folder, "other.md").write_text("# A title: of it\n")
        page.write_text("# Here\n")
        good = ["[x](code.hpp)", "[`bias`](code.hpp)", "[`bias(q, v)`](code.hpp)", "[x](#here)",
                "[`Suite.Holds`](code.hpp)", "[x](other.md#a-title-of-it)", "[x](https://a.b/c)",
                "```\n[x](nowhere)\n```", "[`code.hpp`](code.hpp)", "[folder](.)"]
        bad = ["[x](nowhere.hpp)", "[`torque`](code.hpp)", "[`Suite.Fails`](code.hpp)",
               "[x](#there)", "[x](other.md#no-title)"]
        page_text = "# Here\n\n"
        wrong = [text for text in good if list(links.judge(page, page_text + text))]
        wrong += [text for text in bad if len(list(links.judge(page, page_text + text))) != 1]
    print("\n".join(wrong) if wrong else "links.py sees right")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
