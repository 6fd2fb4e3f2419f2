#pragma once
#include <ostream>
#include <streambuf>
#include <string>

namespace granuscope {
/// Standard output, or standard error, that waits for its reader where the parent has made it non-blocking (runners in
/// node do), instead of giving up in the midst of a text. What is in it when it ends is written.
class StandardOutput : public std::streambuf {
 public:
  explicit StandardOutput(int descriptor = 1) : descriptor_(descriptor) {}
  ~StandardOutput() override { (void)put_out(); }

 protected:
  int_type overflow(int_type letter) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override { return put_out() ? 0 : -1; }

 private:
  bool put_out();
  int descriptor_;
  std::string text_;
};

class Crew;

/// Runs one command line and returns the exit status (see ExitCode). Results go to `out`, messages to `err`; progress
/// goes to the process's standard error. `crew`: other processes that draw ensembles with
/// this one. Never throws and never exits.
int run_command_line(int argc, const char* const* argv, std::ostream& out, std::ostream& err, Crew* crew = nullptr);

}  // namespace granuscope
