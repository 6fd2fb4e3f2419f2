#include <iostream>

#include "cli/command_line.h"

int main(int argc, char** argv) {
  granuscope::StandardOutput buffer;
  std::ostream out(&buffer);
  return granuscope::run_command_line(argc, argv, out, std::cerr);
}
