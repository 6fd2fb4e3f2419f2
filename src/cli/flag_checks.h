#pragma once
#include <CLI/CLI.hpp>

namespace granuscope {

/// A count from 0 to 2^64 - 1, written in digits: CLI11's own conversion silently takes the largest number for a larger
/// one.
CLI::Validator whole_number();

/// Beads along one side of a lattice. One too large for any memory is answered with the memory that it would need.
CLI::Validator lattice_side();

/// A file to be written. "-" would make a file of that name where a stream may have been meant.
CLI::Validator output_file();

}  // namespace granuscope
