"""Checks the links of the site: links.py FOLDER. Every link, picture, style and script must be there, and every anchor.

The references of C, C++ and Rust are made by other programs: links into them are checked, those within them are not.
Links that leave the site are not followed, so that the check needs no network.
"""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """The anchors of a page, and what it links to."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def main(folder):
    root = pathlib.Path(folder).resolve()
    foreign = [root / "reference" / name for name in ("cpp", "rust")]
    pages, wrong, count = {}, 0, 0

    def page(path):
        if path not in pages:
            pages[path] = Page(path.read_text(encoding="utf-8"))
        return pages[path]

    for path in sorted(root.rglob("*.html")):
        if any(path.is_relative_to(other) for other in foreign) or "_downloads" in path.parts:
            continue
        for link in page(path).links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            count += 1
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target = target / "index.html"
            why = None
            if not target.is_relative_to(root) or not target.is_file():
                why = "is not there"
            elif parts.fragment and target.suffix == ".html":
                if urllib.parse.unquote(parts.fragment) not in page(target).anchors:
                    why = "has no such anchor"
            if why:
                wrong += 1
                print(f"{path.relative_to(root)}: {link} {why}")
    print(f"{count} links, {wrong} wrong")
    return 1 if wrong or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
