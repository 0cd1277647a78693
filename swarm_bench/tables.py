"""Tables of texts, for the terminal, as Markdown and as HTML."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from rich.markup import escape
from rich.table import Table as RichTable

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class BenchTable:
    """Rows of cells."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    texts: Collection[str] = ()  # columns that are not of numbers; empty for the first
    styles: Sequence[str] = ()  # of the rows on a terminal; empty for none

    @classmethod
    def of(
        cls,
        columns: Mapping[str, Callable[[T], str]],
        items: Iterable[T],
        *,
        texts: Collection[str] = (),
        style: Callable[[T], str] = lambda item: "",
    ) -> BenchTable:
        """Return a table with a row per item.

        Args:
            columns: Cells by name of the column.
        """
        found = list(items)
        rows = [[cell(item) for cell in columns.values()] for item in found]
        return cls(list(columns), rows, texts, [style(item) for item in found])

    @property
    def is_text(self) -> list[bool]:
        """Whether each column is of texts."""
        return [name in (self.texts or self.head[:1]) for name in self.head]

    def markdown(self) -> str:
        """Return Markdown; a | in a cell is not escaped."""
        ruler = ["---" if is_text else "---:" for is_text in self.is_text]
        return "".join(f"|{'|'.join(row)}|\n" for row in (self.head, ruler, *self.rows))

    def html(self) -> str:
        """Return HTML."""
        from swarm_report.page import table_html

        return table_html(self.head, self.rows)

    def rich(self) -> RichTable:
        """Return the table for a terminal."""
        table = RichTable(box=None, header_style="bold")
        for name, is_text in zip(self.head, self.is_text, strict=True):
            table.add_column(escape(name), justify="left" if is_text else "right")
        for number, row in enumerate(self.rows):
            table.add_row(*map(escape, row), style=self.styles[number] if self.styles else "")
        return table


def number(value: float | None, digits: int = 3) -> str:
    """Return a number for a table, - for None."""
    return "-" if value is None else f"{value:.{digits}f}"


def contacts_text(count: int) -> str:
    """Return a number of contact episodes in words."""
    return "1 contact" if count == 1 else f"{count} contacts"
