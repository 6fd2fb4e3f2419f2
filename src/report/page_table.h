#pragma once
#include <string>
#include <string_view>

#include "report/page_scope.h"

namespace granuscope {

/// The HTML of a table that templates/<file> describes, at a place of summary.json; nothing if it has no rows.
///
///     caption: Share of the beads that had to draw another number
///     class: redrawn
///     rows: piles
///     group: mu
///
///     <var>μ</var>    :: heading number :: {{mu}}
///     beads of a pile :: number         :: {{columns}} × {{layers}}
///     share           :: main number    :: {{share|plain}} :: some_share
///
/// Keys come first. caption: a template over the place where the table stands. class: of <table>, for the style sheets.
/// rows: a list, one row for each element; "results > windows" is a list within each element of a list. where: only the
/// rows that have this ("^this": that have it not). group: a new block begins where one of these values changes. after:
/// HTML behind each row, over the row. end: HTML behind the last row, over the table's place. A line for each column
/// follows: title, kind, cell and, if only some tables have the column, what the table's place must have for it ("^":
/// must not have). Title and cell are HTML templates (report/page_scope.h), the cell over a row. Of the kind's words,
/// heading makes the cell the row's heading, once leaves it empty but in the first row of a block, and number, main,
/// name and after are for the style sheets. A second "rows:" begins a further block with columns and titles of its own.
///
/// A line that begins with a space goes on with the one before; # begins a comment. Throws std::logic_error with file
/// and line for what is not of this form.
std::string page_table(const std::string& file, const PageScope& place);

/// The same from the text of the file; `file` names it in messages.
std::string page_table(const std::string& file, std::string_view text, const PageScope& place);

}  // namespace granuscope
