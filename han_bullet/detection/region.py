"""Parts of pictures and of what is made from them, so that nothing is computed that nobody looks at."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Region:
    """A rectangle of a grid of pixels or cells.

    Attributes:
        rows, columns: Of the grid, without gaps.
        grid: How many rows and columns that has.
    """

    rows: range
    columns: range
    grid: tuple[int, int]

    @classmethod
    def all_of(cls, rows: int, columns: int) -> Region:
        """Return a whole grid."""
        return cls(range(rows), range(columns), (rows, columns))

    @property
    def slices(self) -> tuple[slice, slice]:
        """Return what cuts the region out of the grid."""
        return self.within(Region.all_of(*self.grid))

    def within(self, larger: Region) -> tuple[slice, slice]:
        """Return what cuts the region out of a larger one of the same grid."""
        return _shifted(self.rows, larger.rows.start), _shifted(self.columns, larger.columns.start)

    def grown(self, margin: int) -> Region:
        """Return the region with a margin around it, as far as the grid reaches."""
        return Region(_grown(self.rows, margin, self.grid[0]), _grown(self.columns, margin, self.grid[1]), self.grid)

    def refined(self, factor: int) -> Region:
        """Return the same region of a grid so many times as fine: the pixels of cells."""
        return Region(
            _times(self.rows, factor), _times(self.columns, factor), (factor * self.grid[0], factor * self.grid[1])
        )

    def joined(self, other: Region | None) -> Region:
        """Return the smallest region that holds this one and another of the same grid."""
        if other is None:
            return self
        return Region(_joined(self.rows, other.rows), _joined(self.columns, other.columns), self.grid)


def _shifted(places: range, start: int) -> slice:
    return slice(places.start - start, places.stop - start)


def _grown(places: range, margin: int, end: int) -> range:
    return range(max(places.start - margin, 0), min(places.stop + margin, end))


def _times(places: range, factor: int) -> range:
    return range(factor * places.start, factor * places.stop)


def _joined(places: range, others: range) -> range:
    return range(min(places.start, others.start), max(places.stop, others.stop))
