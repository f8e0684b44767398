#!/usr/bin/env python3
"""Checks the links of a site that is built, and those of the Markdown files beside it.

    scripts/links.py SITE FILE.md…

Of every page in the folder SITE: a link or picture that leads into the site must lead to a file that is there, and what
stands behind `#` must be an anchor in it; every page must be reached from index.html by links. Pages must load nothing from
elsewhere. Of a Markdown file: what it links to beside itself must be there. Addresses elsewhere are not asked.
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# The address of a missing page is not known, so that its links are those of the root.
NOT_FOUND = "404.html"


class Page(HTMLParser):
    """The anchors of a page, what it links to and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loads = set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        self.anchors |= {of[key] for key in ("id", "name") if of.get(key)}
        if tag in ("a", "area") and of.get("href") is not None:
            self.links.append(of["href"])
        loaded = of.get("src") or (of.get("href") if tag == "link" else None)
        if loaded:
            self.loads.append(loaded)


def is_elsewhere(link):
    """Whether it leads out of the site."""
    parts = urlsplit(link)
    return bool(parts.scheme or parts.netloc)


def check_site(site):
    """The faults of a site, and how many links it has."""
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    faults, reached, count = [], {site / "index.html"}, 0
    edges = {path: set() for path in pages}
    for path, page in pages.items():
        name = path.relative_to(site)
        faults += [f"{name}: loads {link} from elsewhere" for link in page.loads if is_elsewhere(link)]
        for link in page.links + page.loads:
            if is_elsewhere(link) or link.startswith("data:"):
                continue
            count += 1
            parts = urlsplit(link)
            base = site if name.name == NOT_FOUND or parts.path.startswith("/") else path.parent
            target = (base / unquote(parts.path).lstrip("/")).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            if not target.is_file():
                faults.append(f"{name}: {link} leads to nothing")
                continue
            edges[path].add(target)
            # What the theme's scripts make of an address is their affair.
            if parts.fragment and target in pages and not parts.fragment.startswith("__"):
                if unquote(parts.fragment) not in pages[target].anchors:
                    faults.append(f"{name}: {link}: there is no such anchor")
    waiting = [site / "index.html"]
    while waiting:
        for target in edges.get(waiting.pop(), set()) & set(pages):
            if target not in reached:
                reached.add(target)
                waiting.append(target)
    faults += [f"{path.relative_to(site)}: no link leads here" for path in pages if path not in reached and path.name != NOT_FOUND]
    return faults, len(pages), count


def check_markdown(path):
    """The faults of a Markdown file, and how many links it has."""
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", prose) if not is_elsewhere(link)]
    faults = []
    for link in links:
        target = path.parent / unquote(urlsplit(link).path)
        if not target.exists():
            faults.append(f"{path}: {link} leads to nothing")
    return faults, len(links)


def main():
    """See the head of this file."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    site, files = Path(sys.argv[1]).resolve(), [Path(name) for name in sys.argv[2:]]
    if not (site / "index.html").is_file():
        sys.exit(f"{site} holds no index.html: build the site first (make site)")
    faults, pages, count = check_site(site)
    for file in files:
        more, links = check_markdown(file)
        faults, count = faults + more, count + links
    if faults:
        sys.exit("\n".join(dict.fromkeys(faults)))
    print(f"links: {count} on {pages} pages and in {len(files)} files, all lead somewhere")


if __name__ == "__main__":
    main()
