#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace granuscope {

/// One finished figure with its files; paths are relative to the run's folder.
struct Figure {
  std::string id;  ///< "response-profiles", also the stem of its files
  std::string title;
  std::string caption;                      ///< at most 60 words, the finding first; plain text, UTF-8
  std::string details = {};                 ///< how it is made and what it leaves out, for those who want to know
  std::string alternative;                  ///< what a reader who cannot see it must know
  std::string paper_says;                   ///< what the paper reports about it, paraphrased
  std::filesystem::path screen;             ///< SVG, or PNG for a rendered picture
  std::filesystem::path narrow = {};        ///< SVG for a phone, panels one above the other; empty where none is needed
  std::filesystem::path print;              ///< PDF, or PNG for a rendered picture
  std::filesystem::path script;             ///< gnuplot script, empty for a rendered picture
  std::filesystem::path recipe;             ///< JSON that fills the script again, empty for a rendered picture
  std::vector<std::filesystem::path> data;  ///< CSV
  std::string redraw;                       ///< the command that makes it again
  std::string failure = {};                 ///< why it could not be made in this run; empty if it was

  /// Whether there is an image: of this run, or of an earlier one from the same script and data.
  bool is_there() const { return !screen.empty(); }
};

/// Makes a figure in the run's folder. Throws InputError if there is nothing to show.
using FigurePlot = std::function<Figure(const std::filesystem::path& run_folder)>;

}  // namespace granuscope
