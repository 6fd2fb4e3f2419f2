#include "support/error.h"

#include <fmt/ranges.h>

#include <cerrno>
#include <system_error>

namespace granuscope {
InputError::InputError(std::vector<std::string> messages)
    : Error(ExitCode::bad_input, fmt::format("{}", fmt::join(messages, "\n"))), messages_(std::move(messages)) {}

Problem in_table(const std::string& table, Problem found) {
  if (found) found->key.insert(0, table + ".");
  return found;
}

void refuse(const Problem& found) {
  if (found) throw InputError(found->key + ": " + found->message);
}

namespace {

const char* advice(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return " Free some space there or choose another folder.";
    case EFBIG:
      return " Raise the limit on file sizes (ulimit -f) or choose another file system.";
    case EACCES:
    case EPERM:
      return " Change the permissions or choose another folder.";
    case EROFS:
      return " Choose a folder that can be written.";
    case ENOENT:
      return " Check the spelling of the path and that its folder exists.";
    case ENOTDIR:
      return " A part of the path is a file where a folder is needed: check the path.";
    case EISDIR:
      return " A folder stands where a file is needed: name a file in it.";
    case EMFILE:
    case ENFILE:
      return " Raise the limit on open files (ulimit -n).";
    case ENAMETOOLONG:
      return " Choose a shorter name.";
    case EAGAIN:
    case ENOMEM:
      return " Free some memory or end other programs, then try again.";
    case EIO:
      return " Check the disk.";
    default:
      return "";
  }
}

}  // namespace

std::string system_reason(int error_number) {
  return std::error_code(error_number, std::generic_category()).message() + "." + advice(error_number);
}

}  // namespace granuscope
