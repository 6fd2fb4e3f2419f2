#pragma once
#include <map>
#include <string>

namespace CLI {
class App;
}

namespace granuscope {
/// What an installation has beside the program, made from the very objects that read the command line: manual pages and
/// completion files for bash, zsh and fish. Path below share/ -> content.
std::map<std::string, std::string> installed_files(const CLI::App& app);

}  // namespace granuscope
