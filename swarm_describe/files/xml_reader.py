"""XML as Gazebo's reader (tinyxml2) takes it, which is less strict than the standard.

A prefix is part of a name, declared or not. A file that is not well-formed XML is read again with
what tinyxml2 allows: `--` in comments, blank lines and comments before the declaration, a bare `&`
and unknown entities as text, `<` in attributes, attributes without a space between them, a wrong
encoding in the declaration. Files that declare entities are read strictly only: expat limits
what these may grow to.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

NAME = r"[A-Za-z_:\x80-\U0010ffff][-.:\w]*"
ATTRIBUTE = re.compile(rf"\s*({NAME})\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
TOKEN = re.compile(
    rf"""(?P<gone><!--.*?(?:-->|\Z)|<\?.*?(?:\?>|\Z)|<!(?!\[CDATA\[).*?(?:>|\Z))
    |<!\[CDATA\[(?P<cdata>.*?)(?:\]\]>|\Z)
    |</(?P<end>{NAME})\s*>
    |<(?P<start>{NAME})(?P<attributes>(?:{ATTRIBUTE.pattern.replace("(" + NAME, "(?:" + NAME)})*)
      \s*(?P<empty>/?)>
    |(?P<text>[^<]+)
    |(?P<wrong><)""",
    re.DOTALL | re.VERBOSE,
)
REFERENCE = re.compile(r"&(?:#x([0-9a-fA-F]{1,6})|#([0-9]{1,7})|(amp|lt|gt|quot|apos));")
ENTITIES = {"amp": "&", "lt": "<", "gt": ">", "quot": '"', "apos": "'"}
FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # by XML 1.0


@dataclass(frozen=True, slots=True)
class XmlFile:
    """Content of an XML file."""

    root: ET.Element  # the outermost element
    outside: str  # text around it, which nobody reads


def read_xml(data: bytes) -> XmlFile:
    """Return the contents of an XML file.

    Raises:
        ExpatError: If it cannot be read, with the line.
        ValueError: If it holds more than one outermost element, or none.
    """
    try:
        return XmlFile(_tree(data), "")
    except (expat.ExpatError, LookupError, ValueError):  # of the text, or of its encoding
        if b"<!ENTITY" in data or b"\0" in data or b"<" not in data:
            raise
    mended = TOKEN.sub(_token, _decoded(data))  # well-formed; the lines stay where they are
    whole = _tree(f"<all>{mended}</all>".encode())
    if len(whole) != 1:
        names = ", ".join(f"<{child.tag}>" for child in whole) or "none"
        raise ValueError(f"malformed XML: outermost elements: {names}; expected one")
    outside = f"{whole.text or ''} {whole[0].tail or ''}".strip()
    whole[0].tail = None
    return XmlFile(whole[0], outside)


def _tree(data: bytes) -> ET.Element:
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.SkippedEntityHandler = parser.ExternalEntityRefHandler = _refuse_entity
    parser.Parse(data, True)
    return builder.close()


def _refuse_entity(name: str, *_more: object) -> int:
    raise ValueError(f"malformed XML: the entity &{name}; is not declared in the file")


def _decoded(data: bytes) -> str:
    """Return the text of a file, whatever its declaration says: UTF-8, or else one byte each."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _token(match: re.Match[str]) -> str:
    if match["gone"] is not None:
        return "\n" * match["gone"].count("\n")
    if match["cdata"] is not None:
        return escape(_allowed(match["cdata"]))
    if match["text"] is not None:
        return escape(_resolved(match["text"]))
    if match["start"] is not None:
        pairs = ATTRIBUTE.findall(match["attributes"])
        given = "".join(f" {name}={quoteattr(_resolved(a or b))}" for name, a, b in pairs)
        lines = "\n" * match[0].count("\n")
        return f"<{match['start']}{given}{lines}{match['empty']}>"
    return match[0]  # an end; or what is left for expat to name


def _resolved(text: str) -> str:
    """Return a text with the references that XML knows replaced, and all others as they are."""
    return _allowed(REFERENCE.sub(_character, text))


def _character(reference: re.Match[str]) -> str:
    if reference[3]:
        return ENTITIES[reference[3]]
    code = int(reference[1], 16) if reference[1] else int(reference[2])
    found = chr(code) if code <= 0x10FFFF else ""
    return reference[0] if not found or FORBIDDEN.match(found) else found


def _allowed(text: str) -> str:
    return FORBIDDEN.sub("\ufffd", text)
