"""Checks a built site: what its pages link to or load is there, and nothing is loaded from elsewhere.

SPDX-License-Identifier: BSD-3-Clause
Usage: check.py FOLDER
"""
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Anchors of a page, where it links to and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loads = {""}, [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.anchors.update(attrs[key] for key in ("id", "name") if attrs.get(key))
        if tag == "a" and attrs.get("href"):
            self.links.append(attrs["href"])
        if tag == "link" and attrs.get("href") and "stylesheet" in attrs.get("rel", ""):
            self.loads.append(attrs["href"])
        if tag in ("script", "img", "iframe", "object") and (attrs.get("src") or attrs.get("data")):
            self.loads.append(attrs.get("src") or attrs["data"])


def main(folder):
    pages = {path.resolve(): Page(path) for path in folder.rglob("*.html") if "mathjax" not in path.parts}
    bad = count = 0
    for path, page in pages.items():
        for target, loaded in [(t, False) for t in page.links] + [(t, True) for t in page.loads]:
            parts = urlsplit(target)
            if parts.scheme in ("javascript", "data", "mailto"):
                continue
            count += 1
            if parts.scheme or parts.netloc:
                if loaded:
                    print(f"{path}: loads {target}")
                    bad += 1
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not file.exists():
                print(f"{path}: there is no {target}")
                bad += 1
            elif file in pages and unquote(parts.fragment) not in pages[file].anchors:
                print(f"{path}: nothing is called {target}")
                bad += 1
    print(f"{len(pages)} pages, {count} links")
    return 1 if bad or not pages else 0


sys.exit(main(Path(sys.argv[1])))
