"""Hook of mkdocs.yml: documents outside of docs/ become pages, and links to them lead there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
OUTSIDE = ("ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "study/protocol.md")
LINK = re.compile(rf"\]\(((?:\.\./)+)({'|'.join(map(re.escape, OUTSIDE))})")


def on_files(files: Any, config: Any) -> Any:
    """Add the documents outside of docs/ as pages, where they lie seen from the root."""
    from mkdocs.structure.files import File

    for name in OUTSIDE:
        text = (ROOT / name).read_text("utf-8").replace("](docs/", "](")
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Shorten links that leave docs/ for such a document: in the site it is inside."""
    climb = "../" * (page.file.src_uri.count("/") + 1)

    def inside(match: re.Match[str]) -> str:
        return f"]({match[1].removeprefix('../') if match[1] == climb else match[1]}{match[2]}"

    return LINK.sub(inside, markdown)
