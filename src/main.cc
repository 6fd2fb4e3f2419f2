#include <ostream>

#include "cli/command_line.h"

int main(int argc, char** argv) {
  granuscope::StandardOutput output, errors(2);
  std::ostream out(&output), err(&errors);
  err << std::unitbuf;  // in step with the progress
  return granuscope::run_command_line(argc, argv, out, err);
}
