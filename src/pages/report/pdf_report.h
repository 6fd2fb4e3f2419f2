#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "report/report_data.h"

namespace granuscope {
/// The report's bytes as PDF, or why there are none.
struct PdfOutcome {
  std::string bytes;
  std::string failure;  ///< one sentence; not empty if and only if bytes is empty
};

/// The content of html_report for print, made by WeasyPrint: contents with page numbers, bookmarks, vector plots. The
/// same data give the same bytes. A missing, failing or hanging WeasyPrint is an outcome, not an exception: the caller
/// decides. `run_folder` must be writable (a hidden folder is made there for the time of the call).
PdfOutcome pdf_report(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                      double timeout_seconds = 300);

/// "data:<media type>;base64,...", which a page can hold instead of a link to a file.
std::string data_uri(const std::string& media_type, std::string_view bytes);

/// The same of a text in UTF-8 with %20 for what ends a URL, an attribute or a candidate of srcset: a quarter shorter.
/// Not for WeasyPrint.
std::string text_uri(const std::string& media_type, std::string_view text);

/// How wide a PNG is at its own resolution (chunks IHDR and pHYs), so that text laid out in points stays that large on
/// paper. Nothing if it states no resolution or is no PNG.
std::optional<double> png_width_mm(std::string_view png);

/// A gnuplot SVG that WeasyPrint 57 can render. gnuplot writes each point as <use xlink:href='#gpPt6' color='...'> of a
/// shape that paints with fill='currentColor', which makes WeasyPrint raise a ValueError. Here the point shapes are
/// copied once for each colour in use, the colour written out, and every point refers to the copy of its colour.
/// Nothing else changes; an SVG without points comes back as it was.
std::string svg_for_weasyprint(std::string_view svg);

}  // namespace granuscope
