#pragma once

namespace granuscope {

/// From now on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) only set a flag (a second one ends the
/// process at once, status 4), and a file-size limit or a closed pipe makes writes fail instead of ending the process.
void install_interruption_handlers();
bool interruption_requested();
/// Throws Interrupted if the flag is set. Called between stages and samples, and now and then in the midst of a pile.
void throw_if_interrupted();
/// Sets or clears the flag by hand (tests).
void request_interruption(bool requested);

}  // namespace granuscope
