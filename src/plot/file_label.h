#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace granuscope {

/// What the file of a figure says of itself, wherever it is taken to: an SVG in <title> and <desc>, a PDF in its
/// document information.
struct FileLabel {
  std::string title;
  std::string command;  ///< that makes it
  std::string program;  ///< provenance_line of the one that made it: version, commit, compiler
};

/// A gnuplot SVG with the label in the place of gnuplot's own. Throws EnvironmentError if there is no such place.
std::string labelled_svg(std::string svg, const FileLabel& label);

/// A PDF of cairo with the label, as an update behind the file. Throws EnvironmentError for a PDF of another build.
std::string labelled_pdf(std::string pdf, const FileLabel& label);

/// The label of an SVG, if it has one.
std::optional<FileLabel> label_of_svg(std::string_view svg);

/// The PDF with every object as it stands and a table of them in plain text. cairo from 1.18 on packs some of them, so
/// that neither a date in them can be taken away without moving all that follows, nor an object be replaced. A PDF that
/// has a plain table, as cairo 1.16 writes it, is returned as it is. Throws EnvironmentError for one that is neither.
std::string with_plain_objects(std::string pdf);

}  // namespace granuscope
